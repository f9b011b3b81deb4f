#include "fluovox/core/error.h"
#include "fluovox/voxelize/mesh_readers.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <optional>
#include <utility>

namespace fluovox {
namespace {

enum class PlyType { Int8, Uint8, Int16, Uint16, Int32, Uint32, Float, Double };

struct PlyProperty {
    std::string name;
    PlyType type = PlyType::Float;
    std::optional<PlyType> count_type;  ///< of a list
};

struct PlyElement {
    std::string name;
    long long count = 0;
    std::vector<PlyProperty> properties;
};

enum class PlyFormat { Ascii, LittleEndian, BigEndian };

struct PlyHeader {
    PlyFormat format = PlyFormat::Ascii;
    std::vector<PlyElement> elements;
};

std::optional<PlyType> ply_type(std::string_view word) {
    using Row = std::pair<std::string_view, PlyType>;
    static constexpr std::array kTypes = {
        Row{"char", PlyType::Int8},     Row{"int8", PlyType::Int8},     Row{"uchar", PlyType::Uint8},
        Row{"uint8", PlyType::Uint8},   Row{"short", PlyType::Int16},   Row{"int16", PlyType::Int16},
        Row{"ushort", PlyType::Uint16}, Row{"uint16", PlyType::Uint16}, Row{"int", PlyType::Int32},
        Row{"int32", PlyType::Int32},   Row{"uint", PlyType::Uint32},   Row{"uint32", PlyType::Uint32},
        Row{"float", PlyType::Float},   Row{"float32", PlyType::Float}, Row{"double", PlyType::Double},
        Row{"float64", PlyType::Double}};
    for (const auto& [name, type] : kTypes) {
        if (name == word) return type;
    }
    return {};
}

PlyType require_type(std::string_view word, const TextScanner& in) {
    const auto type = ply_type(word);
    if (!type) in.fail("\"" + std::string(word.substr(0, 40)) + "\" is not a PLY type");
    return *type;
}

void parse_property(TextScanner& in, std::vector<PlyElement>& elements) {
    if (elements.empty()) in.fail("a property comes before any element");
    PlyProperty property;
    auto word = in.token();
    if (word == "list") {
        property.count_type = require_type(in.token(), in);
        word = in.token();
    }
    property.type = require_type(word, in);
    property.name = in.token();
    elements.back().properties.push_back(property);
}

PlyFormat parse_format(TextScanner& in) {
    const auto format = in.token();
    if (format == "binary_little_endian") return PlyFormat::LittleEndian;
    if (format == "binary_big_endian") return PlyFormat::BigEndian;
    if (format != "ascii") in.fail("has an unknown format");
    return PlyFormat::Ascii;
}

PlyHeader parse_header(TextScanner& in) {
    PlyHeader header;
    if (!in.next_line('\0') || in.token() != "ply") in.fail("is not a PLY file (it does not begin with \"ply\")");
    bool has_format = false;
    while (in.next_line('\0')) {
        const auto keyword = in.token();
        if (keyword == "format") {
            has_format = true;
            header.format = parse_format(in);
        } else if (keyword == "element") {
            PlyElement element;
            element.name = in.token();
            element.count = in.integer();
            if (element.count < 0) in.fail("has a negative number of elements");
            header.elements.push_back(element);
        } else if (keyword == "property") {
            parse_property(in, header.elements);
        } else if (keyword == "end_header") {
            if (!has_format) in.fail("its header names no format");
            return header;
        } else if (keyword != "comment" && keyword != "obj_info") {
            in.fail("\"" + std::string(keyword.substr(0, 40)) + "\" has no meaning in a PLY header");
        }
    }
    in.fail("is truncated: its header has no end");
}

std::string truncated(const PlyElement& element, long long number) {
    return "is truncated: it ends at \"" + element.name + "\" " + std::to_string(number + 1) + " of " +
           std::to_string(element.count);
}

/// Numbers of a binary body, one after the other.
class BinaryNumbers {
public:
    /// `body` is the end of a file of `file_size` bytes.
    BinaryNumbers(std::string_view body, std::size_t file_size, bool big_endian, std::string name)
        : rest_(body),
          file_size_(file_size),
          swap_(big_endian != (std::endian::native == std::endian::big)),
          name_(std::move(name)) {}

    double next(PlyType type) {
        switch (type) {
            case PlyType::Int8:
                return take<std::int8_t>();
            case PlyType::Uint8:
                return take<std::uint8_t>();
            case PlyType::Int16:
                return take<std::int16_t>();
            case PlyType::Uint16:
                return take<std::uint16_t>();
            case PlyType::Int32:
                return take<std::int32_t>();
            case PlyType::Uint32:
                return take<std::uint32_t>();
            case PlyType::Float:
                return static_cast<double>(take<float>());
            case PlyType::Double:
                return take<double>();
        }
        return 0;
    }
    void next_element(const PlyElement& element, long long number) {
        element_ = &element;
        number_ = number;
        if (rest_.empty()) fail_truncated();
    }
    [[noreturn]] void fail(const std::string& message) const {
        throw InputError(name_ + ": byte " + std::to_string(file_size_ - rest_.size()) + ": " + message);
    }

private:
    template <class T>
    T take() {
        if (rest_.size() < sizeof(T)) fail_truncated();
        std::array<char, sizeof(T)> bytes{};
        std::copy_n(rest_.begin(), sizeof(T), bytes.begin());
        if (swap_) std::reverse(bytes.begin(), bytes.end());
        rest_.remove_prefix(sizeof(T));
        return std::bit_cast<T>(bytes);
    }
    [[noreturn]] void fail_truncated() const { fail(truncated(*element_, number_)); }

    std::string_view rest_;
    std::size_t file_size_;
    bool swap_;
    std::string name_;
    const PlyElement* element_ = nullptr;
    long long number_ = 0;
};

/// The same of a text body.
class TextNumbers {
public:
    explicit TextNumbers(TextScanner& in) : in_(in) {}

    double next(PlyType /*type*/) { return in_.number(); }
    void next_element(const PlyElement& element, long long number) {
        if (!in_.next_line('\0')) in_.fail(truncated(element, number));
    }
    [[noreturn]] void fail(const std::string& message) const { in_.fail(message); }

private:
    TextScanner& in_;
};

/// Where x, y, z lie among the properties of a vertex; -1 where absent.
std::array<int, 3> find_coordinates(const PlyElement& element) {
    std::array<int, 3> places = {-1, -1, -1};
    for (std::size_t i = 0; i < element.properties.size(); ++i) {
        const auto& property = element.properties[i];
        if (property.count_type || property.name.size() != 1) continue;
        const int axis = property.name[0] - 'x';
        if (axis >= 0 && axis < 3) places[static_cast<std::size_t>(axis)] = static_cast<int>(i);
    }
    return places;
}

/// Reads the numbers of element `number`: those of the property `wanted` (a list) into `list`, single ones into
/// `single`.
template <class Numbers>
void read_element(Numbers& in, const PlyElement& element, long long number, std::vector<double>& single,
                  std::vector<double>& list) {
    in.next_element(element, number);
    for (std::size_t i = 0; i < element.properties.size(); ++i) {
        const PlyProperty& property = element.properties[i];
        if (!property.count_type) {
            single[i] = in.next(property.type);
            continue;
        }
        const double count = in.next(*property.count_type);
        if (!(count >= 0 && count <= 1e9) || count != std::floor(count)) in.fail("a list has an impossible length");
        const bool corners = property.name == "vertex_indices" || property.name == "vertex_index";
        if (corners) list.clear();
        for (double n = 0; n < count; ++n) {
            const double value = in.next(property.type);
            if (corners) list.push_back(value);
        }
    }
}

template <class Numbers>
void read_vertices(Numbers& in, const PlyElement& element, Mesh& mesh) {
    const auto places = find_coordinates(element);
    if (std::any_of(places.begin(), places.end(), [](int p) { return p < 0; })) in.fail("its vertices have no x, y, z");
    std::vector<double> single(element.properties.size());
    std::vector<double> list;
    for (long long i = 0; i < element.count; ++i) {
        read_element(in, element, i, single, list);
        Vec3 vertex;
        for (int axis = 0; axis < 3; ++axis) {
            vertex[axis] = single[static_cast<std::size_t>(places[static_cast<std::size_t>(axis)])];
            if (!std::isfinite(vertex[axis])) in.fail("vertex " + std::to_string(i) + " is not finite");
        }
        mesh.vertices.push_back(vertex);
    }
}

template <class Numbers>
void read_faces(Numbers& in, const PlyElement& element, Mesh& mesh, long long vertices) {
    std::vector<double> single(element.properties.size());
    std::vector<double> list;
    std::vector<std::uint32_t> corners;
    for (long long i = 0; i < element.count; ++i) {
        read_element(in, element, i, single, list);
        corners.clear();
        for (const double index : list) {
            if (!(index >= 0 && index < static_cast<double>(vertices)) || index != std::floor(index)) {
                in.fail("face " + std::to_string(i) + " uses a vertex that does not exist");
            }
            corners.push_back(static_cast<std::uint32_t>(index));
        }
        add_polygon(mesh, corners);
    }
}

template <class Numbers>
Mesh read_body(Numbers& in, const PlyHeader& header) {
    long long vertices = 0;
    for (const PlyElement& element : header.elements)
        if (element.name == "vertex") vertices = element.count;
    Mesh mesh;
    std::vector<double> list;
    for (const PlyElement& element : header.elements) {
        if (element.properties.empty()) continue;  // nothing of it is in the file
        if (element.name == "vertex") {
            read_vertices(in, element, mesh);
        } else if (element.name == "face") {
            read_faces(in, element, mesh, vertices);
        } else {
            std::vector<double> single(element.properties.size());
            for (long long i = 0; i < element.count; ++i)
                read_element(in, element, i, single, list);
        }
    }
    if (mesh.triangles.empty()) in.fail("has no triangles: its header names no faces, or none with three corners");
    if (static_cast<long long>(mesh.vertices.size()) != vertices) {
        in.fail("its faces use vertices that it does not have");
    }
    return mesh;
}

}  // namespace

Mesh parse_ply(std::string_view bytes, const std::string& name) {
    TextScanner in(bytes, name);
    const PlyHeader header = parse_header(in);
    if (header.format == PlyFormat::Ascii) {
        TextNumbers numbers(in);
        return read_body(numbers, header);
    }
    BinaryNumbers numbers(in.rest(), bytes.size(), header.format == PlyFormat::BigEndian, name);
    return read_body(numbers, header);
}

}  // namespace fluovox
