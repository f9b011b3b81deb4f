#include "fluovox/core/atomic_file.h"
#include "fluovox/core/digest.h"
#include "fluovox/core/error.h"
#include "fluovox/volume/vdb_internal.h"
#include "fluovox/volume/vdb_reader.h"
#include "fluovox/volume/vdb_structure.h"

#include <openvdb/io/File.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <fstream>
#include <new>
#include <string_view>

namespace fluovox {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kFloatTree = "Tree_float_5_4_3";

bool equal_ignoring_case(std::string_view a, std::string_view b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                      [](unsigned char x, unsigned char y) { return std::tolower(x) == std::tolower(y); });
}

/// What each grid is asked for by: its name, or where that is another's as well (or there is none) its name and number
/// among them, `EGFP[1]`, as OpenVDB counts them.
std::vector<std::string> addresses(const std::vector<VdbDescriptor>& grids) {
    std::vector<std::string> all;
    for (std::size_t i = 0; i < grids.size(); ++i) {
        const auto same = [&](const VdbDescriptor& other) { return other.name == grids[i].name; };
        const auto before = std::count_if(grids.begin(), grids.begin() + static_cast<std::ptrdiff_t>(i), same);
        const bool alone = std::count_if(grids.begin(), grids.end(), same) == 1;
        const bool has_name = !grids[i].name.empty() || grids.size() == 1;
        all.push_back(alone && has_name ? grids[i].name : grids[i].name + '[' + std::to_string(before) + ']');
    }
    return all;
}

/// "EGFP", "DAPI", for messages.
std::string quoted(const std::vector<std::string>& names) {
    std::string text;
    for (const std::string& name : names)
        text += (text.empty() ? "\"" : ", \"") + name + '"';
    return text;
}

/// "float" of "Tree_float_5_4_3".
std::string value_type(const std::string& tree_type) {
    const auto begin = tree_type.find('_');
    const auto end = tree_type.find('_', begin + 1);
    if (!tree_type.starts_with("Tree_") || end == std::string::npos) return tree_type;
    return tree_type.substr(begin + 1, end - begin - 1);
}

const VdbDescriptor& find_grid(const std::vector<VdbDescriptor>& grids, const std::string& name, const fs::path& file) {
    if (grids.empty()) throw InputError(file.string() + ": has no grids");
    const std::vector<std::string> names = addresses(grids);
    if (name.empty()) {
        if (grids.size() == 1) return grids.front();
        throw InputError(file.string() + ": has several grids, so one must be named: " + quoted(names));
    }
    const auto exact = std::find(names.begin(), names.end(), name);
    if (exact != names.end()) return grids[static_cast<std::size_t>(exact - names.begin())];
    std::vector<std::size_t> fitting;
    for (std::size_t i = 0; i < grids.size(); ++i) {
        if (equal_ignoring_case(grids[i].name, name) || equal_ignoring_case(names[i], name)) fitting.push_back(i);
    }
    if (fitting.size() == 1) return grids[fitting.front()];
    if (fitting.empty())
        throw InputError(file.string() + ": has no grid \"" + name + "\"; its grids are " + quoted(names));
    std::vector<std::string> choice;
    choice.reserve(fitting.size());
    for (const std::size_t i : fitting)
        choice.push_back(names[i]);
    throw InputError(file.string() + ": has several grids named \"" + name + "\": ask for one of " + quoted(choice) +
                     " (in a scene: grid.name; fluovox info tells what is in them)");
}

void require_float(const VdbDescriptor& grid, const fs::path& file) {
    if (grid.type == kFloatTree) return;
    throw InputError(file.string() + ": grid \"" + grid.name + "\" holds values of type " + value_type(grid.type) +
                     " (" + grid.type + "); fluovox reads float grids of 32 or 16 bit (Tree_float_5_4_3)");
}

// The grid whose tree another shares, or null.
const VdbDescriptor* parent_of(const VdbDescriptor& grid, const std::vector<VdbDescriptor>& grids,
                               const fs::path& file) {
    if (grid.parent.empty()) return nullptr;
    const auto parent =
        std::find_if(grids.begin(), grids.end(), [&](const VdbDescriptor& g) { return g.unique_name == grid.parent; });
    if (parent == grids.end() || !parent->parent.empty()) {
        throw InputError(file.string() + ": is damaged: grid \"" + grid.name + "\" shares a tree that is absent");
    }
    return &*parent;
}

/// Values that no concentration can have, and the first of them in the order of x, y, z.
struct BadValues {
    std::uint64_t nan = 0, infinite = 0, negative = 0;
    openvdb::Coord first = openvdb::Coord::max();
    float first_value = 0;

    std::uint64_t count() const { return nan + infinite + negative; }
    void add(float value, const openvdb::Coord& where, std::uint64_t voxels) {
        if (value >= 0 && !std::isinf(value)) return;
        (std::isnan(value) ? nan : std::isinf(value) ? infinite : negative) += voxels;
        take_first(where, value);
    }
    void add(const BadValues& other) {
        nan += other.nan;
        infinite += other.infinite;
        negative += other.negative;
        if (other.count() > 0) take_first(other.first, other.first_value);
    }
    void take_first(const openvdb::Coord& where, float value) {
        if (where < first) {
            first = where;
            first_value = value;
        }
    }
};

BadValues find_bad_values(const openvdb::FloatGrid& grid) {
    using Leaf = openvdb::FloatTree::LeafNodeType;
    std::vector<const Leaf*> leaves;
    leaves.reserve(grid.baseTree().leafCount());
    grid.tree().getNodes(leaves);
    BadValues bad = tbb::parallel_reduce(
        tbb::blocked_range<std::size_t>(0, leaves.size(), 256), BadValues{},
        [&](const tbb::blocked_range<std::size_t>& range, BadValues found) {
            for (std::size_t i = range.begin(); i != range.end(); ++i) {
                const Leaf& leaf = *leaves[i];
                const float* const values = leaf.buffer().data();
                for (openvdb::Index n = 0; n < Leaf::SIZE; ++n)
                    if (!(values[n] >= 0 && std::isfinite(values[n]))) {
                        found.add(values[n], leaf.offsetToGlobalCoord(n), 1);
                    }
            }
            return found;
        },
        [](BadValues a, const BadValues& b) {
            a.add(b);
            return a;
        });
    auto tile = grid.cbeginValueAll();
    tile.setMaxDepth(openvdb::FloatTree::ValueAllCIter::LEAF_DEPTH - 1);
    for (; tile; ++tile)
        bad.add(*tile, tile.getCoord(), tile.getVoxelCount());
    return bad;
}

void require_concentrations(const openvdb::FloatGrid& grid, const fs::path& file) {
    const std::string place = file.string() + ": grid \"" + grid.getName() + '"';
    const std::string cure =
        "convert it: fluovox voxelize --from-levelset " + file.string() + " -o OUT.vdb --dye NAME=CONCENTRATION";
    if (grid.getGridClass() == openvdb::GRID_LEVEL_SET) {
        throw InputError(place + " is a level set (distances to a surface), not a concentration; " + cure);
    }
    if (!(grid.background() >= 0 && std::isfinite(grid.background()))) {
        throw InputError(place + ": its background value " + std::to_string(grid.background()) +
                         " is no concentration");
    }
    const BadValues bad = find_bad_values(grid);
    if (bad.count() == 0) return;
    std::string kinds;
    const auto add = [&](std::uint64_t count, const char* kind) {
        if (count > 0) kinds += (kinds.empty() ? "" : ", ") + std::to_string(count) + ' ' + kind;
    };
    add(bad.nan, "NaN");
    add(bad.infinite, "infinite");
    add(bad.negative, "negative");
    const auto& c = bad.first;
    const openvdb::Vec3d world = grid.indexToWorld(c);
    std::string message = place + ": " + std::to_string(bad.count()) + " voxels are no concentrations (" + kinds +
                          "); the first is " + std::to_string(bad.first_value) + " at voxel [" + std::to_string(c.x()) +
                          ", " + std::to_string(c.y()) + ", " + std::to_string(c.z()) + "], position [" +
                          std::to_string(world.x()) + ", " + std::to_string(world.y()) + ", " +
                          std::to_string(world.z()) + ']';
    if (bad.negative > 0 && grid.background() > 0) message += ". If it is a level set, " + cure;
    throw InputError(message);
}

std::string text_metadata(const openvdb::GridBase& grid, const char* key) {
    const auto value = grid.getMetadata<openvdb::StringMetadata>(key);
    return value ? value->value() : std::string();
}

/// The library gives every file a random identifier (a UUID). One that follows from the rest makes files of the same
/// content the same. Throws std::exception.
void set_identifier(const fs::path& file) {
    constexpr std::size_t kAt = 21;  // behind the magic number, three versions and a flag
    constexpr std::size_t kSize = 36;
    Digest digest;
    digest.add_file(file, kAt, kSize);
    std::string text = digest.finish().substr(0, kSize);
    for (const std::size_t dash : {8U, 13U, 18U, 23U})
        text[dash] = '-';
    text[14] = text[19] = '8';  // RFC 9562: digits of our own making
    std::fstream out(file, std::ios::binary | std::ios::in | std::ios::out);
    out.exceptions(std::ios::failbit | std::ios::badbit);
    out.seekp(kAt);
    out.write(text.data(), kSize);
    out.close();
}

/// Throws std::exception.
void add_checksum(const fs::path& file) {
    const std::string line = vdb_checksum_line(file);
    std::ofstream out(file, std::ios::binary | std::ios::app);
    out.exceptions(std::ios::failbit | std::ios::badbit);
    out.write(line.data(), static_cast<std::streamsize>(line.size()));
    out.close();
}

}  // namespace

void initialize_openvdb() {
    static const bool done = [] {
        openvdb::initialize();
        // It only serves delayed loading, which we don't use, and its reader trusts the file.
        openvdb::Metadata::unregisterType("__delayedload");
        return true;
    }();
    (void)done;
}

std::vector<GridEntry> list_grids(const fs::path& file) {
    std::vector<GridEntry> entries;
    const std::vector<VdbDescriptor> grids = read_vdb_directory(file);
    const std::vector<std::string> names = addresses(grids);
    for (std::size_t i = 0; i < grids.size(); ++i)
        entries.push_back({names[i], value_type(grids[i].type), grids[i].half, grids[i].type == kFloatTree});
    return entries;
}

void require_grid(const fs::path& file, const std::string& name) {
    find_grid(read_vdb_directory(file), name, file);
}

openvdb::GridBase::Ptr load_any_grid(const fs::path& file, const std::string& name) {
    const auto grids = read_vdb_directory(file);
    const VdbDescriptor& wanted = find_grid(grids, name, file);
    check_vdb_checksum(file);
    return read_vdb_grid(file, wanted, parent_of(wanted, grids, file));
}

openvdb::FloatGrid::Ptr load_any_float_grid(const fs::path& file, const std::string& name) {
    const auto grids = read_vdb_directory(file);
    const VdbDescriptor& wanted = find_grid(grids, name, file);
    require_float(wanted, file);
    check_vdb_checksum(file);
    check_vdb_float_grid(file, wanted);
    const VdbDescriptor* const parent = parent_of(wanted, grids, file);
    if (parent != nullptr) {
        require_float(*parent, file);
        check_vdb_float_grid(file, *parent);
    }
    auto grid = openvdb::gridPtrCast<openvdb::FloatGrid>(read_vdb_grid(file, wanted, parent));
    if (!grid) throw InputError(file.string() + ": grid \"" + wanted.name + "\" cannot be read");
    return grid;
}

openvdb::FloatGrid::Ptr load_float_grid(const fs::path& file, const std::string& name) {
    auto grid = load_any_float_grid(file, name);
    require_concentrations(*grid, file);
    return grid;
}

GridMetadata grid_metadata(const openvdb::GridBase& grid) {
    return {text_metadata(grid, "dye"),           text_metadata(grid, "value_unit"),
            text_metadata(grid, "length_unit"),   text_metadata(grid, "source"),
            text_metadata(grid, "source_sha256"), text_metadata(grid, "fluovox_version")};
}

void set_grid_metadata(openvdb::GridBase& grid, const GridMetadata& metadata) {
    const auto set = [&](const char* key, const std::string& value) {
        if (value.empty()) return;
        grid.removeMeta(key);
        grid.insertMeta(key, openvdb::StringMetadata(value));
    };
    set("dye", metadata.dye);
    set("value_unit", metadata.value_unit);
    set("length_unit", metadata.length_unit);
    set("source", metadata.source);
    set("source_sha256", metadata.source_sha256);
    set("fluovox_version", metadata.fluovox_version);
}

void save_grids(const fs::path& file, const std::vector<openvdb::GridBase::Ptr>& grids) {
    initialize_openvdb();
    write_atomically(file, [&](const fs::path& temporary) {
        try {
            openvdb::io::File out(temporary.string());
            out.write(openvdb::GridPtrVec(grids.begin(), grids.end()));
            // The library doesn't notice every failed write; the table of contents does, since it must fit the file.
            if (read_vdb_directory(temporary).size() == grids.size()) {
                set_identifier(temporary);
                return add_checksum(temporary);
            }
        } catch (const std::bad_alloc&) {
            throw;
        } catch (const std::exception& e) {
            throw OutputError(file.string() + ": could not be written (disk full?): " + e.what());
        }
        throw OutputError(file.string() + ": could not be written (disk full?)");
    });
}

}  // namespace fluovox
