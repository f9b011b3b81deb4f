#pragma once

#include <filesystem>
#include <optional>

namespace fluovox {

/// A file that one run holds for itself. The system drops the lock with the process, however it ends, so that none is
/// ever left behind; the file itself stays.
class FileLock {
public:
    /// Makes the file where it is missing. Nothing where another process (or another lock of this one) holds it. On a
    /// file system that knows no locks everybody gets one. Throws OutputError where the file cannot be made.
    static std::optional<FileLock> take(const std::filesystem::path& file);

    FileLock(FileLock&& other) noexcept;
    FileLock& operator=(FileLock&& other) noexcept;
    ~FileLock();
    FileLock(const FileLock&) = delete;
    FileLock& operator=(const FileLock&) = delete;

private:
    explicit FileLock(int descriptor) : descriptor_(descriptor) {}

    int descriptor_ = -1;
};

}  // namespace fluovox
