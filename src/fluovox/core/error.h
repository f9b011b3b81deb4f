#pragma once

#include <stdexcept>
#include <string>

namespace fluovox {

/// What the program exits with; part of the contract with scripts.
enum class ExitCode {
    Ok = 0,
    Different = 1,  ///< `fluovox diff` only
    Usage = 2,      ///< the command line is wrong
    Scene = 3,      ///< the scene or dye file is invalid
    Input = 4,      ///< input data are bad, missing or unreadable
    Output = 5,     ///< a result could not be written
    Internal = 70,  ///< a mistake of ours
    Stopped = 75,   ///< stopped cleanly; run again to continue
};

/// Something the user can put right: a bad scene file, a missing volume, a full disk.
/// Mistakes of ours are assertions instead, and are never caught.
class Error : public std::runtime_error {
public:
    Error(ExitCode code, const std::string& message) : std::runtime_error(message), code_(code) {}

    ExitCode code() const { return code_; }

private:
    ExitCode code_;
};

/// A wrong command line; the program prints the usage of the sub-command beside it.
class UsageError : public Error {
public:
    explicit UsageError(const std::string& message) : Error(ExitCode::Usage, message) {}
};

/// Bad, missing or unreadable input data. The message starts with the file's name.
class InputError : public Error {
public:
    explicit InputError(const std::string& message) : Error(ExitCode::Input, message) {}
};

/// A result that could not be written. The message starts with the file's name.
class OutputError : public Error {
public:
    explicit OutputError(const std::string& message) : Error(ExitCode::Output, message) {}
};

/// A place in a text file; lines and columns start at 1.
struct SourceLocation {
    std::string file;
    int line = 0;
    int column = 0;
};

/// An error with a place: `what()` reads "scene.toml:12:5: error: ...".
class SceneError : public Error {
public:
    SceneError(SourceLocation where, const std::string& message);

    const SourceLocation& where() const { return where_; }

private:
    SourceLocation where_;
};

}  // namespace fluovox
