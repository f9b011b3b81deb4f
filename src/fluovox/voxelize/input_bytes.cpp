#include "fluovox/voxelize/input_bytes.h"

#include "fluovox/core/error.h"

#include <fcntl.h>
#include <openssl/sha.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <utility>

namespace fluovox {

namespace fs = std::filesystem;

std::string load_bytes(const fs::path& file) {
    std::error_code failure;
    if (fs::is_directory(file, failure)) throw InputError(file.string() + ": is a folder, not a file");
    errno = 0;
    std::ifstream in(file, std::ios::binary);
    if (!in) throw InputError(file.string() + ": cannot be read: " + std::strerror(errno));
    const auto size = fs::file_size(file, failure);
    std::string bytes(failure ? 0 : static_cast<std::size_t>(size), '\0');
    in.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    if (failure || in.gcount() != static_cast<std::streamsize>(bytes.size())) {
        throw InputError(file.string() + ": cannot be read");
    }
    return bytes;
}

MappedBytes::MappedBytes(const fs::path& file) {
    std::error_code failure;
    if (fs::is_directory(file, failure)) throw InputError(file.string() + ": is a folder, not a file");
    const int descriptor = ::open(file.c_str(), O_RDONLY | O_CLOEXEC);  // NOLINT(*-vararg)
    if (descriptor < 0) throw InputError(file.string() + ": cannot be read: " + std::strerror(errno));
    struct stat status {};
    bool mapped = ::fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode);
    if (mapped && status.st_size > 0) {
        start_ = ::mmap(nullptr, static_cast<std::size_t>(status.st_size), PROT_READ, MAP_PRIVATE, descriptor, 0);
        mapped = start_ != MAP_FAILED;
        if (mapped) size_ = static_cast<std::size_t>(status.st_size);
        if (!mapped) start_ = nullptr;
    }
    ::close(descriptor);
    if (!mapped) throw InputError(file.string() + ": cannot be read");
}

MappedBytes::~MappedBytes() {
    if (start_ != nullptr) ::munmap(start_, size_);
}

void MappedBytes::swap(MappedBytes& other) noexcept {
    std::swap(start_, other.start_);
    std::swap(size_, other.size_);
}

std::string sha256_hex(std::string_view bytes) {
    std::array<unsigned char, SHA256_DIGEST_LENGTH> digest{};
    SHA256(reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size(),  // NOLINT(*-reinterpret-cast): bytes
           digest.data());
    constexpr std::string_view kDigits = "0123456789abcdef";
    std::string text;
    for (const unsigned char byte : digest) {
        text += kDigits[byte >> 4U];
        text += kDigits[byte & 15U];
    }
    return text;
}

}  // namespace fluovox
