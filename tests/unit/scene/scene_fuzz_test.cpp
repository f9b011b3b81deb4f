#include "fluovox/core/rng.h"

#include "unit/scene/scene_fixture.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <iterator>

namespace fluovox::testing {
namespace {

class SceneFuzz : public SceneTest {};

/// A few random damages: bytes changed, pieces cut out, doubled, or swapped for pieces that have a meaning.
std::string damaged(std::string text, Rng& rng) {
    static constexpr std::array kPieces = {
        "\"",           "[",          "]",      "{",        "}", "=",  "\n",         "-",    "1e999",
        "nan",          "inf",        "true",   "\"5 um\"", "0", "-1", "1979-05-27", "\xff", "9223372036854775807",
        "[[medium]]\n", "[camera]\n", "\"\"\"", "'",        ".", "{}", "[]",         "[["};
    const auto below = [&](std::size_t n) { return static_cast<std::size_t>(rng.uniform() * static_cast<double>(n)); };
    const std::size_t damages = 1 + below(3);
    for (std::size_t i = 0; i < damages && !text.empty(); ++i) {
        const std::size_t at = below(text.size());
        const std::size_t length = below(std::min<std::size_t>(text.size() - at, 40)) + 1;
        const std::size_t digit = std::min(text.find_first_of("0123456789", at), text.size() - 1);
        switch (below(6)) {
            case 0:
                text[at] = static_cast<char>(below(256));
                break;
            case 4:
                text[digit] = static_cast<char>('0' + below(10));
                break;
            case 1:
                text.erase(at, length);
                break;
            case 2:
                text.insert(at, text.substr(at, length));
                break;
            case 3:
                text.replace(at, below(4), kPieces[below(kPieces.size())]);
                break;
            default:
                text.erase(at, 1);
        }
    }
    return text;
}

// Whatever is wrong with a scene, the user hears of it by an Error; anything else would end as an internal error.
TEST_F(SceneFuzz, DamagedScenesGiveErrorsAndNothingElse) {
    int accepted = 0;
    int refused = 0;
    for (std::uint64_t i = 0; i < 4000; ++i) {
        Rng rng(20, 0, i);
        const std::string text = damaged(kScene, rng);
        try {
            const std::string json = to_json(load(text));
            EXPECT_FALSE(json.empty());
            ++accepted;
        } catch (const Error& e) {
            EXPECT_FALSE(std::string(e.what()).empty());
            ++refused;
        } catch (const std::exception& e) {
            ADD_FAILURE() << "case " << i << ": " << e.what() << "\n" << text;
        }
    }
    EXPECT_GT(accepted, 50) << "damages too heavy to reach the deeper readers";
    EXPECT_GT(refused, 2000) << "damages too light";
}

TEST_F(SceneFuzz, DamagedOverridesGiveErrorsAndNothingElse) {
    for (std::uint64_t i = 0; i < 1000; ++i) {
        Rng rng(21, 0, i);
        const std::string option = damaged("medium.1.region.box.min.0=\"-5 mm\"", rng);
        try {
            load(kScene, {option});
        } catch (const Error& e) {
            EXPECT_FALSE(std::string(e.what()).empty());
        } catch (const std::exception& e) {
            ADD_FAILURE() << "case " << i << ": " << e.what() << "\n" << option;
        }
    }
}

}  // namespace
}  // namespace fluovox::testing
