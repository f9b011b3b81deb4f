#include "fluovox/scene/toml_document.h"

#include "fluovox/core/text.h"

#include <fmt/format.h>

#include <charconv>
#include <cstddef>
#include <memory>
#include <system_error>

namespace fluovox {
namespace {

constexpr std::size_t kMostShown = 60;

std::string first_letter_lower(std::string text) {
    if (!text.empty() && text[0] >= 'A' && text[0] <= 'Z') text[0] = static_cast<char>(text[0] - 'A' + 'a');
    return text;
}

// What the parser says, and what is most often behind it.
std::string parse_complaint(const toml::parse_error& failure) {
    std::string message = shown(failure.description(), 300);
    message = first_letter_lower(fmt::format("not a scene: {}", first_letter_lower(std::move(message))));
    if (failure.description().find("expected a comment or whitespace") != std::string_view::npos) {
        message += "; texts and quantities need quotes, for example \"6.5 um\"";
    }
    if (failure.description().find("not representable in 64 bits") != std::string_view::npos)
        message += ": whole numbers, such as a seed, go up to 9223372036854775807";
    return message;
}

std::vector<std::string> split_path(std::string_view path) {
    std::vector<std::string> steps;
    for (std::size_t begin = 0;;) {
        const std::size_t end = std::min(path.find('.', begin), path.size());
        steps.emplace_back(path.substr(begin, end - begin));
        if (end == path.size()) return steps;
        begin = end + 1;
    }
}

[[noreturn]] void fail_override(const std::string& option, const std::string& message) {
    throw SceneError({"--set " + shown(std::string_view(option)), 0, 0}, message);
}

// A table with the value under "value". What TOML does not understand is a text: shells eat quotes.
toml::table parse_value(const std::string& text) {
    try {
        toml::table table = toml::parse("value = " + text);
        if (table.size() == 1 && table.contains("value")) return table;
    } catch (const toml::parse_error&) {  // NOLINT(bugprone-empty-catch): the text itself then is the value
    }
    return toml::table{{"value", text}};
}

toml::node* step_into(toml::node& parent, const std::string& step, const std::string& option) {
    if (auto* table = parent.as_table()) {
        if (!table->contains(step)) table->insert(step, toml::table{});
        return table->get(step);
    }
    if (auto* array = parent.as_array()) {
        std::size_t index = 0;
        const auto [end, failure] = std::from_chars(step.data(), step.data() + step.size(), index);
        const bool is_number = failure == std::errc{} && end == step.data() + step.size();
        if (is_number && index < array->size()) return array->get(index);
        fail_override(option, fmt::format("\"{}\" should be a number from 0 to {}: there are {} entries", shown(step),
                                          array->empty() ? 0 : array->size() - 1, array->size()));
    }
    fail_override(option, fmt::format("nothing can be set at \"{}\": what is before it is a plain value", shown(step)));
}

}  // namespace

std::string shown(std::string_view text, std::size_t most) {
    std::string result;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const auto c = static_cast<unsigned char>(text[i]);
        const bool begins_letter = (c & 0xC0U) != 0x80U;
        if (i >= most && begins_letter) return result + "...";
        result += c < ' ' || c == 0x7F ? '?' : text[i];
    }
    return result;
}

std::string shown(const toml::node& value) {
    if (const auto text = value.value_exact<std::string_view>()) return '"' + shown(*text) + '"';
    if (const auto number = value.value_exact<std::int64_t>()) return fmt::format("{}", *number);
    if (const auto number = value.value_exact<double>()) return fmt::format("{}", *number);
    if (const auto flag = value.value_exact<bool>()) return fmt::format("{}", *flag);
    if (const auto* array = value.as_array()) {
        std::string items;
        for (const toml::node& item : *array) {
            if (items.size() > kMostShown) return '[' + items + ", ...]";
            items += (items.empty() ? "" : ", ") + (item.is_table() ? "{...}" : shown(item));
        }
        return '[' + items + ']';
    }
    return value.is_table() ? "" : "a date";
}

TomlDocument parse_toml(const std::string& text, const std::string& file) try {
    if (const int line = line_of_deep_key(text); line > 0)
        throw SceneError({file, line, 1}, "not a scene: a key with more than 256 dots");
    return {toml::parse(text, file), file, {}};
} catch (const toml::parse_error& e) {
    const toml::source_position at = e.source().begin;
    throw SceneError({file, static_cast<int>(at.line), static_cast<int>(at.column)}, parse_complaint(e));
}

void apply_override(TomlDocument& document, const std::string& option) {
    const std::size_t equals = option.find('=');
    if (equals == std::string::npos || equals == 0) {
        throw UsageError("--set takes KEY=VALUE, for example --set camera.resolution=[64,64], not \"" +
                         shown(std::string_view(option)) + '"');
    }
    const std::string path = option.substr(0, equals);
    std::vector<std::string> steps = split_path(path);
    if (steps.size() > kDeepestKey) fail_override(option, "the key has too many dots");
    const std::string last = steps.back();
    steps.pop_back();
    toml::node* parent = &document.root;
    for (const std::string& step : steps)
        parent = step_into(*parent, step, option);

    toml::table value = parse_value(option.substr(equals + 1));
    toml::node& node = *value.get("value");
    if (auto* table = parent->as_table()) {
        node.visit([&](auto&& typed) { table->insert_or_assign(last, std::forward<decltype(typed)>(typed)); });
    } else {
        toml::node* place = step_into(*parent, last, option);
        auto* array = parent->as_array();
        std::size_t index = 0;
        while (array->get(index) != place)
            ++index;
        node.visit([&](auto&& typed) { array->replace(array->cbegin() + static_cast<std::ptrdiff_t>(index), typed); });
    }
    document.overridden.emplace(document.overridden.begin(), path, option);
}

SourceLocation location_of(const TomlDocument& document, const toml::source_region& region, std::string_view path) {
    for (const auto& [set, option] : document.overridden) {
        const bool under = path.substr(0, set.size()) == set && (path.size() == set.size() || path[set.size()] == '.');
        if (under) return {"--set " + shown(std::string_view(option)), 0, 0};
    }
    return {document.file, static_cast<int>(region.begin.line), static_cast<int>(region.begin.column)};
}

}  // namespace fluovox
