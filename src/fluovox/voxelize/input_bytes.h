#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

namespace fluovox {

/// All bytes of a file. Throws InputError when it is missing, a folder or unreadable.
std::string load_bytes(const std::filesystem::path& file);

/// A file whose bytes come into memory as they are looked at: for files that may be larger than it.
class MappedBytes {
public:
    MappedBytes() = default;
    /// Throws what `load_bytes` throws.
    explicit MappedBytes(const std::filesystem::path& file);
    MappedBytes(MappedBytes&& other) noexcept { swap(other); }
    MappedBytes& operator=(MappedBytes&& other) noexcept {
        swap(other);
        return *this;
    }
    MappedBytes(const MappedBytes&) = delete;
    MappedBytes& operator=(const MappedBytes&) = delete;
    ~MappedBytes();

    std::string_view bytes() const { return {static_cast<const char*>(start_), size_}; }

private:
    void swap(MappedBytes& other) noexcept;

    void* start_ = nullptr;
    std::size_t size_ = 0;
};

/// SHA-256 in 64 hexadecimal digits.
std::string sha256_hex(std::string_view bytes);

}  // namespace fluovox
