#pragma once

#include <nlohmann/json.hpp>

#include <optional>

namespace fluovox::tools {

/// What is not known is null in JSON, never a zero that looks measured.
inline nlohmann::ordered_json json_or_null(std::optional<double> value) {
    return value ? nlohmann::ordered_json(*value) : nlohmann::ordered_json(nullptr);
}

}  // namespace fluovox::tools
