#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

namespace fluovox {

/// SHA-256 of all that is added, one after the other.
class Digest {
public:
    Digest();
    ~Digest();
    Digest(const Digest&) = delete;
    Digest& operator=(const Digest&) = delete;

    void add(std::string_view bytes);
    /// The content of a file, but for `skipped` bytes from `skip_from` on. Throws InputError where it cannot be read.
    void add_file(const std::filesystem::path& path, std::size_t skip_from = 0, std::size_t skipped = 0);
    /// 64 hexadecimal digits; nothing can be added afterwards.
    std::string finish();

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace fluovox
