#pragma once

// Internal: libtiff behind exceptions. Not installed.

#include <tiffio.h>

#include <filesystem>
#include <functional>
#include <memory>
#include <string>

namespace fluovox {

/// An open TIFF file; what libtiff says of an error ends in `message` instead of on stderr.
class TiffFile {
public:
    /// `mode` as TIFFOpen. `is_open` is false when it could not be opened.
    TiffFile(const std::filesystem::path& path, const char* mode);

    bool is_open() const { return tiff_ != nullptr; }
    TIFF* get() { return tiff_.get(); }
    const std::string& message() const { return *message_; }
    void close() { tiff_.reset(); }

private:
    struct Close {
        void operator()(TIFF* tiff) const { TIFFClose(tiff); }
    };

    std::unique_ptr<std::string> message_ = std::make_unique<std::string>();  // stays where the library was told
    std::unique_ptr<TIFF, Close> tiff_;
};

}  // namespace fluovox
