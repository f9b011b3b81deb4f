#include "fluovox/image/tiff_file.h"

#include <array>
#include <cstdarg>
#include <cstdio>

namespace fluovox {
namespace {

int keep_message(TIFF* /*tiff*/, void* message, const char* /*module*/, const char* format, va_list arguments) {
    std::array<char, 512> text{};
    std::vsnprintf(text.data(), text.size(), format, arguments);
    auto& kept = *static_cast<std::string*>(message);
    if (kept.empty()) kept = text.data();
    return 1;
}

int ignore_warning(TIFF* /*tiff*/, void* /*data*/, const char* /*module*/, const char* /*format*/,
                   va_list /*arguments*/) {
    return 1;
}

}  // namespace

TiffFile::TiffFile(const std::filesystem::path& path, const char* mode) {
    TIFFOpenOptions* options = TIFFOpenOptionsAlloc();
    TIFFOpenOptionsSetErrorHandlerExtR(options, keep_message, message_.get());
    TIFFOpenOptionsSetWarningHandlerExtR(options, ignore_warning, nullptr);
    tiff_.reset(TIFFOpenExt(path.c_str(), mode, options));
    TIFFOpenOptionsFree(options);
}

}  // namespace fluovox
