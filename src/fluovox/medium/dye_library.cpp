#include "fluovox/medium/dye_library.h"

#include "fluovox/core/embedded_text.h"
#include "fluovox/core/text.h"
#include "fluovox/medium/dye_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace fluovox {
namespace {

/// A common name that stands for one of the library.
struct Alias {
    const char* name;
    const char* id;
    const char* remark;
};

constexpr std::array kAliases = {
    Alias{"gfp", "egfp",
          "\"GFP\" is taken as EGFP (peaks 489/511 nm here), the nearest to the usual GFP curves with peaks at "
          "489/508 nm"},
    Alias{"rfp", "dsred", "\"RFP\" is taken as DsRed (emission peak 583 nm)"},
};

/// What counts of a name: letters (all that are not ASCII too) and digits in lower case, and "Alexa Fluor" is "Alexa".
std::string plain_name(std::string_view name) {
    std::string plain;
    for (const char c : lower_case(name)) {
        const bool is_ascii = static_cast<unsigned char>(c) < 0x80;
        if (!is_ascii || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9')) plain += c;
    }
    constexpr std::string_view kLong = "alexafluor";
    if (plain.rfind(kLong, 0) == 0) plain.replace(0, kLong.size(), "alexa");
    return plain;
}

const Dye* find_plain(const std::string& plain) {
    for (const Dye& dye : dye_library()) {
        if (plain == plain_name(dye.id) || plain == plain_name(dye.name)) return &dye;
    }
    return nullptr;
}

/// Id of a dye that comes as a separate data file; empty when there is none.
std::string find_optional(const std::string& plain) {
    std::string_view ids = embedded_text("medium/data/optional_dyes.txt");
    while (!ids.empty()) {
        const std::size_t end = std::min(ids.find('\n'), ids.size());
        std::string id(ids.substr(0, end));
        if (plain == plain_name(id)) return id;
        ids.remove_prefix(std::min(end + 1, ids.size()));
    }
    return {};
}

}  // namespace

const std::vector<Dye>& dye_library() {
    static const std::vector<Dye> library = [] {
        const std::string folder = "medium/data/dyes/";
        const auto load_curves = [&](const std::string& name) {
            return parse_csv(embedded_text(folder + name), folder + name, 0.0);
        };
        return parse_dye_library(embedded_text(folder + "dyes.toml"), folder + "dyes.toml", load_curves);
    }();
    return library;
}

std::optional<DyeMatch> find_dye(std::string_view name) {
    const std::string plain = plain_name(name);
    for (const Alias& alias : kAliases) {
        if (plain == alias.name) return DyeMatch{*find_plain(alias.id), alias.remark};
    }
    const Dye* dye = find_plain(plain);
    if (dye == nullptr) return {};
    return DyeMatch{*dye, {}};
}

std::vector<std::string> closest_dyes(std::string_view name) {
    std::vector<std::string> candidates;
    for (const Dye& dye : dye_library()) {
        candidates.push_back(plain_name(dye.id));
        if (plain_name(dye.name) != candidates.back()) candidates.push_back(plain_name(dye.name));
    }
    constexpr std::size_t kCount = 3;
    std::vector<std::string> names;
    for (const std::string& near : closest_names(plain_name(name), candidates, 2 * kCount)) {
        const std::string& found = find_plain(near)->name;
        if (names.size() < kCount && std::find(names.begin(), names.end(), found) == names.end())
            names.push_back(found);
    }
    return names;
}

std::string unknown_dye_message(std::string_view name) {
    const std::string optional = find_optional(plain_name(name));
    if (!optional.empty()) {
        return fmt::format(
            "the dye \"{}\" is not built in; it comes as a data file under terms of its own: give the path "
            "of dyes-optional/{}.toml (in data/ of the sources, in share/fluovox/ when installed)",
            name, optional);
    }
    const std::vector<std::string> closest = closest_dyes(name);
    const std::string hint = closest.empty() ? "" : "; did you mean " + quoted_alternatives(closest) + '?';
    return fmt::format(R"(unknown dye "{}"{} ("fluovox dyes" lists them; the path of a dye file works too))", name,
                       hint);
}

std::string_view data_licences() {
    return embedded_text("NOTICE");
}

DyeMatch resolve_dye(const std::string& name, const std::filesystem::path& folder, const SourceLocation& where) {
    const std::filesystem::path path = name;
    if (path.extension() == ".toml" || name.find('/') != std::string::npos) return {load_dye(folder / path), {}};
    if (std::optional<DyeMatch> match = find_dye(name)) return *match;
    throw SceneError(where, unknown_dye_message(name));
}

}  // namespace fluovox
