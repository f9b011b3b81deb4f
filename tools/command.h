#pragma once

#include "fluovox/core/error.h"

#include <boost/program_options.hpp>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace fluovox {
class Progress;
}

namespace fluovox::tools {

namespace po = boost::program_options;

/// One sub-command: its name, what the list of commands says of it, and what it does with its arguments.
struct Command {
    const char* name;
    const char* summary;
    ExitCode (*run)(const std::vector<std::string>& arguments);
};

/// Options that every sub-command takes.
struct CommonOptions {
    bool verbose = false;
    bool quiet = false;
    int threads = 0;  ///< 0: as many as the machine has
    std::string progress = "auto";
    bool json = false;
};

/// The command line of one sub-command: examples, what it takes, what it was given. Shows its help where asked.
class CommandLine {
public:
    /// `usage` is the line after "Usage:"; `examples` is printed first in the help, one command a line.
    CommandLine(std::string usage, std::string examples);

    /// The sub-command's own options, to be filled before `parse`.
    po::options_description& options() { return options_; }
    /// Names the positional arguments: `count` of them go to `name`, -1 for all that remain.
    void positional(const char* name, int count) { positional_.add(name, count); }

    /// Parses; false when only the help was wanted (and printed). Throws UsageError (with the usage) for what it
    /// does not understand. A thread limit that was asked for holds from here on.
    bool parse(const std::vector<std::string>& arguments);

    const po::variables_map& values() const { return values_; }
    const CommonOptions& common() const { return common_; }
    /// The options in the order they were typed, for those whose order matters (`--dye` follows its mesh).
    const std::vector<po::option>& in_order() const { return in_order_; }
    /// The value of an option declared as std::int64_t and given. Throws UsageError when it is below `least`.
    std::int64_t at_least(const char* option, std::int64_t least) const;
    /// The usage line, for messages.
    const std::string& usage() const { return usage_; }

    /// Throws UsageError with `message` and the usage.
    [[noreturn]] void fail(const std::string& message) const;

private:
    void keep_inputs() const;

    std::string usage_;
    std::string examples_;
    po::options_description options_{"Options"};
    po::positional_options_description positional_;
    po::variables_map values_;
    std::vector<po::option> in_order_;
    CommonOptions common_;
};

/// A progress bar on a terminal, plain lines elsewhere, or nothing, as the options say. SIGINT and SIGTERM make it
/// `stopped()`.
std::unique_ptr<Progress> make_progress(const CommonOptions& common);

}  // namespace fluovox::tools
