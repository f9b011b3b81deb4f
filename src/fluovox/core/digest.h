#pragma once

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
    /// The content of a file. Throws InputError where it cannot be read.
    void add_file(const std::filesystem::path& path);
    /// 64 hexadecimal digits; nothing can be added afterwards.
    std::string finish();

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace fluovox
