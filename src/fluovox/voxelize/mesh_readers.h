#pragma once

// The readers behind parse_mesh, one a format. All throw InputError that begins with `name`.

#include "fluovox/voxelize/mesh.h"

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace fluovox {

Mesh parse_obj(std::string_view bytes, const std::string& name);
Mesh parse_off(std::string_view bytes, const std::string& name);
Mesh parse_ply(std::string_view bytes, const std::string& name);
Mesh parse_stl(std::string_view bytes, const std::string& name);
/// By the assimp library; `extension` as in parse_mesh.
Mesh parse_with_assimp(std::string_view bytes, const std::string& extension, const std::string& name);
bool assimp_reads(const std::string& extension);

/// Adds a polygon as a fan of triangles; fewer than three corners add nothing.
void add_polygon(Mesh& mesh, const std::vector<std::uint32_t>& corners);

/// Text with lines, tokens between blanks, and the line number for messages.
class TextScanner {
public:
    TextScanner(std::string_view text, std::string name) : rest_(text), name_(std::move(name)) {}

    /// Goes to the next line that isn't blank and doesn't begin with `comment`; false at the end.
    bool next_line(char comment);
    /// The next token of this line; empty at its end.
    std::string_view token();
    /// The next token of this line as a number. Throws InputError when it is none (or `nan`, `inf`).
    double number();
    /// The same for whole numbers.
    long long integer();
    /// The next token as a number, on as many lines as it takes (`comment` starts one that is passed over).
    double number_anywhere(char comment);
    long long integer_anywhere(char comment);
    bool token_anywhere(char comment, std::string_view& found);

    /// What follows the current line.
    std::string_view rest() const { return rest_; }

    [[noreturn]] void fail(const std::string& message) const;
    /// At the end of a file that has vertices at most.
    [[noreturn]] void fail_without_triangles(std::size_t vertices) const;

private:
    std::string_view rest_;
    std::string_view line_;
    std::string name_;
    long long line_number_ = 0;
};

/// `token` as a number; throws through `where`.
double to_number(std::string_view token, const TextScanner& where);
long long to_integer(std::string_view token, const TextScanner& where);

}  // namespace fluovox
