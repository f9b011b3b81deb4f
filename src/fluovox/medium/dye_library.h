#pragma once

#include "fluovox/core/error.h"
#include "fluovox/medium/dye.h"

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace fluovox {

/// All dyes compiled in, in the order of the library's table.
const std::vector<Dye>& dye_library();

/// A dye found by name, and a remark where the name stands for another ("GFP" means EGFP here).
struct DyeMatch {
    Dye dye;
    std::string remark;  ///< empty, or a sentence the output should repeat
};

/// Finds a dye by id or name, without regard to case, spaces and dashes ("Alexa 488" is Alexa Fluor 488); nothing
/// when there is none.
std::optional<DyeMatch> find_dye(std::string_view name);

/// The closest names of the library, best first, for "did you mean".
std::vector<std::string> closest_dyes(std::string_view name);

/// `unknown dye "EGPF"; did you mean "EGFP"? ...`: what to say when `find_dye` finds nothing.
std::string unknown_dye_message(std::string_view name);

/// The project's NOTICE: where the compiled-in tables come from and on what terms.
std::string_view data_licences();

/// Reads a user's dye file: TOML with the keys name, quantum_yield (0 to 1), extinction ("55900 /M/cm", decadic, at the
/// peak of the excitation curve), spectra (a CSV file beside it with the columns wavelength_nm, excitation and
/// emission, any scale, empty: 0), emission_is ("photons", the default, or "energy"), and, as text, kind, source,
/// licence, note. Throws SceneError with the place in either file; InputError when one of them cannot be read.
Dye load_dye(const std::filesystem::path& file);

/// `name` is a library name, or the path of a dye file (it ends in ".toml" or holds a "/"). A relative path starts at
/// `folder`. Throws SceneError at `where` with the closest names when there is no such dye, and what `load_dye` throws.
DyeMatch resolve_dye(const std::string& name, const std::filesystem::path& folder, const SourceLocation& where);

}  // namespace fluovox
