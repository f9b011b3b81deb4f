#include "command.h"

#include "fluovox/core/text.h"

#include <tbb/global_control.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <iostream>
#include <limits>
#include <memory>
#include <system_error>
#include <utility>

namespace fluovox::tools {
namespace {

// More only cost memory: each has a renderer of its own.
constexpr int kMostThreads = 1024;

po::options_description common_options(CommonOptions& common) {
    po::options_description options("Common options");
    auto add = options.add_options();
    add("help,h", "show this help");
    add("verbose,v", po::bool_switch(&common.verbose), "say more");
    add("quiet,q", po::bool_switch(&common.quiet), "say nothing but errors and results");
    add("threads", po::value(&common.threads)->value_name("N"), "threads to use (default: all)");
    add("progress", po::value(&common.progress)->value_name("auto|bar|plain|none"), "how to show progress");
    add("json", po::bool_switch(&common.json), "print the result as JSON");
    return options;
}

void limit_threads(int threads) {
    static std::unique_ptr<tbb::global_control> limit;  // holds as long as the program runs
    limit = std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism,
                                                  static_cast<std::size_t>(threads));
}

}  // namespace

CommandLine::CommandLine(std::string usage, std::string examples)
    : usage_(std::move(usage)), examples_(std::move(examples)) {}

bool CommandLine::parse(const std::vector<std::string>& arguments) try {
    // Options that another command also has ("--json FILE" of fluence) may be declared by the command itself.
    po::options_description all;
    const auto shared = common_options(common_);
    po::options_description shown("Common options");
    for (const auto& option : shared.options()) {
        if (options_.find_nothrow(option->long_name(), false) == nullptr) shown.add(option);
    }
    all.add(options_).add(shown);

    if (std::any_of(arguments.begin(), arguments.end(), [](auto& a) { return a == "--help" || a == "-h"; })) {
        std::cout << "Examples:\n" << examples_ << "\nUsage: " << usage_ << "\n\n" << options_ << '\n' << shown;
        return false;
    }
    using Style = po::command_line_style::style_t;
    const auto parsed = po::command_line_parser(arguments)
                            .options(all)
                            .positional(positional_)
                            .style(po::command_line_style::unix_style & ~Style::allow_guessing)
                            .run();
    in_order_ = parsed.options;
    po::store(parsed, values_);
    po::notify(values_);
    keep_inputs();
    if (common_.threads < 0) fail("--threads must not be negative");
    if (common_.threads > kMostThreads) {
        fail("--threads must be " + std::to_string(kMostThreads) + " or less; without it all processors are used");
    }
    if (common_.threads > 0) limit_threads(common_.threads);
    static constexpr std::array kProgress = {"auto", "bar", "plain", "none"};
    if (std::find(kProgress.begin(), kProgress.end(), common_.progress) == kProgress.end()) {
        fail("--progress is auto, bar, plain or none, not \"" + common_.progress + '"');
    }
    return true;
} catch (const po::invalid_option_value& e) {
    if (e.get_option_name() == "--seed") {
        fail("--seed must be a whole number from 0 to " + std::to_string(std::numeric_limits<std::int64_t>::max()));
    }
    fail(e.what());
} catch (const po::unknown_option& e) {
    std::vector<std::string> names;
    for (const auto& option : options_.options())
        names.push_back("--" + option->long_name());
    fail(e.what() + did_you_mean(e.get_option_name(), names));
} catch (const po::too_many_positional_options_error&) {
    fail("there are more arguments than this command takes (a text with spaces needs quotes)");
} catch (const po::error& e) {
    fail(e.what());
}

std::int64_t CommandLine::at_least(const char* option, std::int64_t least) const {
    const auto value = values_[option].as<std::int64_t>();
    if (value < least) fail(std::string("--") + option + " must be " + std::to_string(least) + " or more");
    return value;
}

// A slip of the hand must not replace a mesh by its voxels.
void CommandLine::keep_inputs() const {
    static constexpr std::array kOutputs = {"output", "report", "preview", "plot", "p-values"};
    for (const auto& to : in_order_) {
        if (std::find(kOutputs.begin(), kOutputs.end(), to.string_key) == kOutputs.end() || to.value.empty()) continue;
        for (const auto& from : in_order_) {
            std::error_code missing;
            if (from.position_key < 0 || from.value.empty()) continue;
            if (std::filesystem::equivalent(to.value.front(), from.value.front(), missing))
                fail(to.value.front() + ": is an input; give --" + to.string_key + " another name");
        }
    }
}

void CommandLine::fail(const std::string& message) const {
    throw UsageError(message + "\nUsage: " + usage_ + "\nMore: add --help");
}

}  // namespace fluovox::tools
