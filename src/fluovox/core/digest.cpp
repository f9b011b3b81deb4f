#include "fluovox/core/digest.h"

#include "fluovox/core/error.h"

#include <openssl/evp.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <new>
#include <vector>

namespace fluovox {

struct Digest::State {
    EVP_MD_CTX* context = EVP_MD_CTX_new();

    State() {
        if (context == nullptr || EVP_DigestInit_ex(context, EVP_sha256(), nullptr) != 1) throw std::bad_alloc();
    }
    State(const State&) = delete;
    State& operator=(const State&) = delete;
    ~State() { EVP_MD_CTX_free(context); }
};

Digest::Digest() : state_(std::make_unique<State>()) {}
Digest::~Digest() = default;

void Digest::add(std::string_view bytes) {
    if (EVP_DigestUpdate(state_->context, bytes.data(), bytes.size()) != 1) throw std::bad_alloc();
}

void Digest::add_file(const std::filesystem::path& path, std::size_t skip_from, std::size_t skipped) {
    std::ifstream in(path, std::ios::binary);
    std::vector<char> block(std::size_t{1} << 20U);
    in.read(block.data(), static_cast<std::streamsize>(std::min(skip_from, block.size())));
    add({block.data(), static_cast<std::size_t>(in.gcount())});
    if (skipped > 0) in.ignore(static_cast<std::streamsize>(skipped));
    while (in) {
        in.read(block.data(), static_cast<std::streamsize>(block.size()));
        add({block.data(), static_cast<std::size_t>(in.gcount())});
    }
    if (!in.eof()) throw InputError(path.string() + ": cannot be read");
}

std::string Digest::finish() {
    std::array<unsigned char, EVP_MAX_MD_SIZE> bytes{};
    unsigned size = 0;
    if (EVP_DigestFinal_ex(state_->context, bytes.data(), &size) != 1) throw std::bad_alloc();
    constexpr std::string_view kDigits = "0123456789abcdef";
    std::string text;
    for (unsigned i = 0; i < size; ++i) {
        text += kDigits[bytes[i] >> 4U];
        text += kDigits[bytes[i] & 15U];
    }
    return text;
}

}  // namespace fluovox
