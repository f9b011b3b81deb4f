#include "fluovox/core/error.h"

#include <utility>

namespace fluovox {
namespace {

std::string place(const SourceLocation& where) {
    if (where.line == 0) return where.file;
    return where.file + ':' + std::to_string(where.line) + ':' + std::to_string(where.column);
}

}  // namespace

SceneError::SceneError(SourceLocation where, const std::string& message)
    : Error(ExitCode::Scene, place(where) + ": error: " + message), where_(std::move(where)) {}

}  // namespace fluovox
