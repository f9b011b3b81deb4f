#include "fluovox/volume/vdb_reader.h"

#include "fluovox/core/error.h"
#include "fluovox/volume/vdb_internal.h"

#include <openvdb/io/Archive.h>
#include <openvdb/io/GridDescriptor.h>
#include <openvdb/io/io.h>

#include <algorithm>
#include <fstream>
#include <istream>
#include <memory>
#include <new>
#include <streambuf>
#include <vector>

namespace fluovox {
namespace {

/// A file in large pieces, in which seeking within a piece moves a pointer.
class FileBuffer : public std::streambuf {
public:
    explicit FileBuffer(const std::filesystem::path& file) : piece_(kPiece) {
        file_.pubsetbuf(nullptr, 0);
        file_.open(file, std::ios::in | std::ios::binary);
    }

    bool is_open() const { return file_.is_open(); }

protected:
    int_type underflow() override {
        const std::streamsize count = file_.sgetn(piece_.data(), kPiece);
        setg(piece_.data(), piece_.data(), piece_.data() + std::max<std::streamsize>(count, 0));
        end_ += egptr() - eback();
        return gptr() == egptr() ? traits_type::eof() : traits_type::to_int_type(*gptr());
    }
    pos_type seekoff(off_type offset, std::ios::seekdir from, std::ios::openmode mode) override {
        if (from == std::ios::end) return off_type{-1};
        return seekpos(from == std::ios::cur ? end_ - (egptr() - gptr()) + offset : offset, mode);
    }
    pos_type seekpos(pos_type to, std::ios::openmode /*mode*/) override {
        const off_type back = end_ - off_type{to};
        if (back >= 0 && back <= egptr() - eback()) {
            setg(eback(), egptr() - back, egptr());
            return to;
        }
        end_ = file_.pubseekpos(to, std::ios::in);
        setg(nullptr, nullptr, nullptr);
        return end_;
    }

private:
    static constexpr std::streamsize kPiece = 1 << 20;

    std::filebuf file_;
    std::vector<char> piece_;
    off_type end_ = 0;  // of the piece, in the file
};

/// What OpenVDB has for its own readers. The stream refers to it.
class GridArchive : public openvdb::io::Archive {
public:
    explicit GridArchive(std::istream& in) : in_(&in) {
        readHeader(in);
        openvdb::io::setStreamMetadataPtr(in, metadata_, /*transfer=*/false);
        setFormatVersion(in);
        setLibraryVersion(in);
        setDataCompression(in);
    }

    openvdb::GridBase::Ptr read(const VdbDescriptor& grid) const {
        openvdb::io::GridDescriptor descriptor(grid.name, grid.type, grid.half);
        descriptor.setInstanceParentName(grid.parent);
        auto result = openvdb::GridBase::createGrid(grid.type);
        result->setSaveFloatAsHalf(grid.half);
        in_->seekg(static_cast<std::streamoff>(grid.grid_position));
        readGrid(result, descriptor, *in_);
        return result;
    }

private:
    std::istream* in_;
    openvdb::SharedPtr<openvdb::io::StreamMetadata> metadata_ = std::make_shared<openvdb::io::StreamMetadata>();
};

}  // namespace

openvdb::GridBase::Ptr read_vdb_grid(const std::filesystem::path& file, const VdbDescriptor& grid,
                                     const VdbDescriptor* parent) {
    initialize_openvdb();
    FileBuffer buffer(file);
    if (!buffer.is_open()) throw InputError(file.string() + ": cannot be read");
    try {
        std::istream in(&buffer);
        in.exceptions(std::ios::failbit | std::ios::badbit);
        const GridArchive archive(in);
        auto result = archive.read(grid);
        if (parent != nullptr) result->setTree(archive.read(*parent)->baseTreePtr());
        result->setName(grid.name);
        return result;
    } catch (const std::bad_alloc&) {
        throw InputError(file.string() + ": needs more memory than there is");
    } catch (const std::exception& e) {
        throw InputError(file.string() + ": is damaged: " + e.what());
    }
}

}  // namespace fluovox
