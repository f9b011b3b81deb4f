#include "fluovox/volume/vdb_structure.h"

#include "fluovox/core/error.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <limits>
#include <string_view>
#include <utility>

namespace fluovox {
namespace {

// The layout follows the format documentation in OpenVDB's headers (io/Archive, io/Compression, tree/*Node).
constexpr std::int64_t kMagic = 0x56444220;
constexpr std::uint32_t kOldestVersion = 222;  // node masks are compressed from here on: OpenVDB 2.0 (2013)
constexpr std::uint32_t kNewestVersion = 224;
constexpr std::uint32_t kZip = 1, kActiveMask = 2, kBlosc = 4;
constexpr std::uint32_t kLeafValues = 512;
constexpr std::uint64_t kUuidPosition = 21, kUuidLength = 36;
constexpr std::string_view kChecksumMark = "\nfluovox crc32 ";
constexpr std::size_t kChecksumLine = kChecksumMark.size() + 8 + 1;  // digits and the line's end
constexpr std::string_view kHalfSuffix = "_HalfFloat";

/// The bytes of a file, mapped; read front to back, never past the end.
class FileBytes {
public:
    explicit FileBytes(const std::filesystem::path& file) : file_(file.string()) {
        const int descriptor = ::open(file_.c_str(), O_RDONLY | O_CLOEXEC);
        if (descriptor < 0) throw InputError(file_ + ": cannot be read: " + std::strerror(errno));
        struct stat status {};
        const bool regular = ::fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode);
        if (regular && status.st_size > 0) {
            size_ = static_cast<std::size_t>(status.st_size);
            void* const begin = ::mmap(nullptr, size_, PROT_READ, MAP_PRIVATE, descriptor, 0);
            if (begin != MAP_FAILED) bytes_ = static_cast<const char*>(begin);
        }
        ::close(descriptor);
        if (!regular) throw InputError(file_ + ": is not a file");
        if (size_ == 0) throw InputError(file_ + ": is empty");
        if (bytes_ == nullptr) throw InputError(file_ + ": cannot be read");
    }
    FileBytes(const FileBytes&) = delete;
    FileBytes& operator=(const FileBytes&) = delete;
    ~FileBytes() {
        // munmap wants a pointer to non-const bytes and doesn't write through it.
        ::munmap(const_cast<char*>(bytes_), size_);  // NOLINT(cppcoreguidelines-pro-type-const-cast)
    }

    std::size_t size() const { return size_; }
    std::size_t position() const { return position_; }
    void seek(std::uint64_t position) {
        if (position > size_) truncated();
        position_ = static_cast<std::size_t>(position);
    }
    const char* skip(std::uint64_t count) {
        if (count > size_ - position_) truncated();
        const char* const here = bytes_ + position_;
        position_ += static_cast<std::size_t>(count);
        return here;
    }
    template <class T>
    T read() {
        T value;
        std::memcpy(&value, skip(sizeof value), sizeof value);
        return value;
    }
    std::string text() {
        const auto length = read<std::uint32_t>();
        return {skip(length), length};
    }
    [[noreturn]] void truncated() const {
        throw InputError(file_ + ": is truncated or damaged: it ends before its last grid does");
    }
    [[noreturn]] void damaged(const std::string& what) const { throw InputError(file_ + ": is damaged: " + what); }

private:
    std::string file_;
    std::size_t size_ = 0;
    std::size_t position_ = 0;
    const char* bytes_ = nullptr;
};

/// Bytes that a metadata value of this type has, or 0 where any number will do.
std::uint32_t metadata_size(std::string_view type) {
    using Row = std::pair<std::string_view, std::uint32_t>;
    static constexpr std::array kSizes = {Row{"bool", 1},   Row{"int32", 4},  Row{"int64", 8},  Row{"float", 4},
                                          Row{"double", 8}, Row{"vec2d", 16}, Row{"vec2i", 8},  Row{"vec2s", 8},
                                          Row{"vec3d", 24}, Row{"vec3i", 12}, Row{"vec3s", 12}, Row{"vec4d", 32},
                                          Row{"vec4i", 16}, Row{"vec4s", 16}, Row{"mat4s", 64}, Row{"mat4d", 128}};
    for (const auto& [name, size] : kSizes) {
        if (name == type) return size;
    }
    return 0;
}

void skip_metadata(FileBytes& in) {
    const auto count = in.read<std::uint32_t>();
    for (std::uint32_t i = 0; i < count; ++i) {
        in.text();
        const std::string type = in.text();
        const auto size = in.read<std::uint32_t>();
        const std::uint32_t expected = metadata_size(type);
        if (expected != 0 && size != expected) in.damaged("metadata of type " + type + " has a wrong size");
        in.skip(size);
    }
}

/// A scale stands with what follows from it: the size of a voxel, and the inverse. A matrix has a last column of zeros
/// and a one. Far wider than rounding, since other programs may have computed these.
bool is_consistent(std::string_view type, const std::vector<double>& numbers) {
    constexpr double kRounding = 1e-6;
    if (type == "TranslationMap") return true;
    if (type == "AffineMap" || type == "UnitaryMap") {
        return std::abs(numbers[3]) < kRounding && std::abs(numbers[7]) < kRounding &&
               std::abs(numbers[11]) < kRounding && std::abs(numbers[15] - 1) < kRounding;
    }
    const double* const scale = numbers.data() + (type.ends_with("TranslateMap") ? 3 : 0);
    for (int axis = 0; axis < 3; ++axis) {
        const double size = std::abs(scale[axis]);
        if (std::abs(scale[axis + 3] - size) > kRounding * size) return false;
        if (std::abs(scale[axis + 6] * scale[axis] - 1) > kRounding) return false;
    }
    return true;
}

void check_transform(FileBytes& in) {
    using Row = std::pair<std::string_view, std::uint32_t>;
    static constexpr std::array kNumbers = {Row{"AffineMap", 16},
                                            Row{"UnitaryMap", 16},
                                            Row{"ScaleMap", 15},
                                            Row{"UniformScaleMap", 15},
                                            Row{"TranslationMap", 3},
                                            Row{"ScaleTranslateMap", 18},
                                            Row{"UniformScaleTranslateMap", 18}};
    const std::string type = in.text();
    for (const auto& [name, count] : kNumbers) {
        if (name != type) continue;
        std::vector<double> numbers;
        for (std::uint32_t i = 0; i < count; ++i) {
            const auto value = in.read<double>();
            if (!(std::abs(value) < std::numeric_limits<double>::max())) in.damaged("its transform is not finite");
            numbers.push_back(value);
        }
        if (!is_consistent(type, numbers)) in.damaged("the numbers of its transform contradict each other");
        return;
    }
    if (type == "NonlinearFrustumMap") {
        in.damaged("it has a frustum transform, and fluovox reads affine ones only");
    }
    in.damaged("it has an unknown transform");
}

/// How the values of one grid are stored.
struct Storage {
    std::uint32_t compression = 0;
    std::uint32_t bytes_per_value = 4;
};

/// Passes over one compressed chunk that unpacks to `unpacked` bytes.
void skip_chunk(FileBytes& in, const Storage& storage, std::uint64_t unpacked) {
    if ((storage.compression & (kZip | kBlosc)) == 0) {
        in.skip(unpacked);
        return;
    }
    const auto stored = in.read<std::int64_t>();
    if (stored <= 0) {
        if (stored != -static_cast<std::int64_t>(unpacked)) in.damaged("a block of values has a wrong size");
        in.skip(unpacked);
        return;
    }
    const char* const chunk = in.skip(static_cast<std::uint64_t>(stored));
    if ((storage.compression & kBlosc) == 0) return;  // zlib checks for itself
    constexpr std::int64_t kBloscHeader = 16;
    std::array<std::uint32_t, 3> sizes{};  // unpacked, of a block, packed
    if (stored < kBloscHeader) in.damaged("a block of values is too short");
    std::memcpy(sizes.data(), chunk + 4, sizeof sizes);
    if (sizes[0] != unpacked || sizes[1] == 0 || sizes[1] > std::max<std::uint64_t>(unpacked, 1) ||
        sizes[2] != stored) {
        in.damaged("a block of values has a wrong header");
    }
}

/// Passes over the values of one node. `active` of them are on in its value mask.
void skip_values(FileBytes& in, const Storage& storage, std::uint32_t count, std::uint32_t active) {
    const auto layout = in.read<std::int8_t>();
    if (layout < 0 || layout > 6) in.damaged("a node has an unknown layout");
    const bool one_value = layout == 2 || layout == 4 || layout == 5;
    if (one_value) in.skip(sizeof(float));
    if (layout == 5) in.skip(sizeof(float));
    if (layout >= 3 && layout <= 5) in.skip(count / 8);
    const bool only_active = (storage.compression & kActiveMask) != 0 && layout != 6;
    const std::uint64_t stored = only_active ? active : count;
    // As OpenVDB does: no chunk at all for half values when there are none.
    if (stored == 0 && storage.bytes_per_value == 2) return;
    skip_chunk(in, storage, stored * storage.bytes_per_value);
}

std::uint32_t count_on(const char* mask, std::uint32_t bits) {
    std::uint32_t on = 0;
    for (std::uint32_t byte = 0; byte < bits / 8; byte += sizeof(std::uint64_t)) {
        std::uint64_t word = 0;
        std::memcpy(&word, mask + byte, sizeof word);
        on += static_cast<std::uint32_t>(std::popcount(word));
    }
    return on;
}

/// Passes over an internal node (32^3 above 16^3 above leaves); adds the masks of the leaves below it to `leaf_masks`.
void skip_topology(FileBytes& in, const Storage& storage, int level, std::vector<const char*>& leaf_masks) {
    if (level == 0) {
        leaf_masks.push_back(in.skip(kLeafValues / 8));
        return;
    }
    const std::uint32_t count = level == 2 ? 32 * 32 * 32 : 16 * 16 * 16;
    const std::uint32_t children = count_on(in.skip(count / 8), count);
    const std::uint32_t active = count_on(in.skip(count / 8), count);
    skip_values(in, storage, count, active);
    for (std::uint32_t i = 0; i < children; ++i)
        skip_topology(in, storage, level - 1, leaf_masks);
}

void require_origin(FileBytes& in) {
    constexpr std::int32_t kRootSpan = 4096;  // voxels along the side of a node below the root
    for (int axis = 0; axis < 3; ++axis) {
        if (in.read<std::int32_t>() % kRootSpan != 0) in.damaged("a node of its tree lies off the lattice");
    }
}

void skip_tree(FileBytes& in, const Storage& storage) {
    if (in.read<std::int32_t>() != 1) in.damaged("its tree has several buffers");
    in.skip(sizeof(float));  // background
    const auto tiles = in.read<std::uint32_t>();
    const auto children = in.read<std::uint32_t>();
    for (std::uint32_t i = 0; i < tiles; ++i) {
        require_origin(in);
        in.skip(sizeof(float) + sizeof(bool));
    }
    std::vector<const char*> leaf_masks;
    for (std::uint32_t i = 0; i < children; ++i) {
        require_origin(in);
        skip_topology(in, storage, 2, leaf_masks);
    }
    for (const char* const mask : leaf_masks) {
        // It stands with the tree and again with the values.
        if (std::memcmp(mask, in.skip(kLeafValues / 8), kLeafValues / 8) != 0)
            in.damaged("the two masks of a leaf are not the same");
        skip_values(in, storage, kLeafValues, count_on(mask, kLeafValues));
    }
}

void read_header(FileBytes& in, const std::string& file) {
    if (in.size() < sizeof kMagic || in.read<std::int64_t>() != kMagic) throw InputError(file + ": is not a VDB file");
    const auto version = in.read<std::uint32_t>();
    if (version < kOldestVersion || version > kNewestVersion) {
        throw InputError(file + ": has VDB format version " + std::to_string(version) + ", and fluovox reads " +
                         std::to_string(kOldestVersion) + " to " + std::to_string(kNewestVersion) +
                         "; write it anew with a current OpenVDB (vdb_tool -read IN -write OUT)");
    }
    in.skip(2 * sizeof(std::uint32_t));  // version of the library that wrote it
    if (in.read<char>() == 0) {
        throw InputError(file + ": was streamed and has no table of contents; write it anew " +
                         "(vdb_tool -read IN -write OUT)");
    }
    in.skip(kUuidLength);
}

/// Of the first `count` bytes.
std::string checksum_line(FileBytes& in, std::uint64_t count) {
    in.seek(0);
    const auto* const bytes = reinterpret_cast<const Bytef*>(in.skip(count));  // NOLINT(*-reinterpret-cast): bytes
    constexpr std::uint64_t kBehind = kUuidPosition + kUuidLength;
    uLong crc = crc32_z(0, bytes, kUuidPosition);
    crc = crc32_z(crc, bytes + kBehind, count - kBehind);
    std::array<char, 9> digits{};
    for (std::size_t i = 0; i < 8; ++i)
        digits[i] = "0123456789abcdef"[(crc >> (28 - 4 * i)) & 15U];
    return std::string(kChecksumMark) + digits.data() + '\n';
}

}  // namespace

std::vector<VdbDescriptor> read_vdb_directory(const std::filesystem::path& file) {
    FileBytes in(file);
    read_header(in, file.string());
    skip_metadata(in);
    const auto count = in.read<std::int32_t>();
    if (count < 0) in.damaged("the number of its grids is negative");
    std::vector<VdbDescriptor> grids;
    for (std::int32_t i = 0; i < count; ++i) {
        VdbDescriptor grid;
        grid.unique_name = in.text();
        constexpr char kSeparator = '\x1e';
        grid.name = grid.unique_name.substr(0, grid.unique_name.find(kSeparator));
        grid.type = in.text();
        if (grid.type.ends_with(kHalfSuffix)) {
            grid.half = true;
            grid.type.resize(grid.type.size() - kHalfSuffix.size());
        }
        grid.parent = in.text();
        grid.grid_position = in.read<std::uint64_t>();
        grid.block_position = in.read<std::uint64_t>();
        grid.end_position = in.read<std::uint64_t>();
        // One that shares a tree has no blocks of its own.
        const std::uint64_t blocks = grid.parent.empty() ? grid.block_position : grid.end_position;
        const bool ordered =
            in.position() <= grid.grid_position && grid.grid_position <= blocks && blocks <= grid.end_position;
        if (!ordered || grid.end_position > in.size()) in.truncated();
        in.seek(grid.end_position);
        grids.push_back(std::move(grid));
    }
    return grids;
}

void check_vdb_float_grid(const std::filesystem::path& file, const VdbDescriptor& grid) {
    FileBytes in(file);
    in.seek(grid.grid_position);
    Storage storage;
    storage.compression = in.read<std::uint32_t>();
    storage.bytes_per_value = grid.half ? 2 : 4;
    skip_metadata(in);
    check_transform(in);
    if (!grid.parent.empty()) return;
    skip_tree(in, storage);
    if (in.position() != grid.end_position) in.damaged("a grid does not end where its table of contents says");
}

std::string vdb_checksum_line(const std::filesystem::path& file) {
    FileBytes in(file);
    return checksum_line(in, in.size());
}

void check_vdb_checksum(const std::filesystem::path& file) {
    std::uint64_t end = 0;
    for (const VdbDescriptor& grid : read_vdb_directory(file))
        end = std::max(end, grid.end_position);
    FileBytes in(file);
    if (end == 0) return;
    in.seek(end);
    const std::uint64_t left = in.size() - end;
    const std::string_view line(in.skip(left), left);
    if (line.empty() || !line.starts_with(kChecksumMark.substr(0, line.size()))) return;
    if (line.size() != kChecksumLine || line != checksum_line(in, end))
        in.damaged("its bytes are not those that were written (their checksum is another): copy or make it anew");
}

}  // namespace fluovox
