#include "fluovox/core/atomic_file.h"

#include "fluovox/core/error.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <string>
#include <system_error>

namespace fluovox {
namespace {

namespace fs = std::filesystem;

// A full disk may show itself only when the data reach it.
void flush_to_disk(const fs::path& temporary, const fs::path& path) {
    const int file = ::open(temporary.c_str(), O_RDONLY | O_CLOEXEC);  // NOLINT(*-vararg)
    if (file < 0) throw OutputError(path.string() + ": nothing was written: " + std::strerror(errno));
    const int failed = ::fsync(file);
    const int reason = errno;
    ::close(file);
    if (failed != 0 && reason != EINVAL) throw OutputError(path.string() + ": " + std::strerror(reason));
}

}  // namespace

void require_writable(const fs::path& path) {
    const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
    std::error_code ignored;
    if (!fs::is_directory(folder, ignored)) {
        throw OutputError(path.string() + ": the folder " + folder.string() + " does not exist");
    }
    if (fs::is_directory(path, ignored)) throw OutputError(path.string() + ": is a folder");
    if (fs::exists(path, ignored) && !fs::is_regular_file(path, ignored)) {
        throw OutputError(path.string() + ": is not a file that can be replaced (a device or a pipe)");
    }
    if (::access(folder.c_str(), W_OK) != 0) {
        throw OutputError(path.string() + ": cannot write in " + folder.string() + ": " + std::strerror(errno));
    }
}

void write_atomically(const fs::path& path, const std::function<void(const fs::path& temporary)>& write) {
    require_writable(path);
    // The temporary keeps the extension, since some libraries choose the format by it.
    const fs::path temporary = path.parent_path() / ("." + path.stem().string() + "." + std::to_string(::getpid()) +
                                                     path.extension().string());
    std::error_code ignored;
    try {
        write(temporary);
        flush_to_disk(temporary, path);
    } catch (...) {
        fs::remove(temporary, ignored);
        throw;
    }
    std::error_code failure;
    fs::rename(temporary, path, failure);
    if (failure) {
        fs::remove(temporary, ignored);
        throw OutputError(path.string() + ": " + failure.message());
    }
}

void write_text_file(const fs::path& path, std::string_view text) {
    write_atomically(path, [&](const fs::path& temporary) {
        std::ofstream out(temporary, std::ios::binary);
        out.write(text.data(), static_cast<std::streamsize>(text.size()));
        out.close();
        if (!out) throw OutputError(path.string() + ": could not be written: " + std::strerror(errno));
    });
}

}  // namespace fluovox
