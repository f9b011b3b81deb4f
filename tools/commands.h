#pragma once

#include "command.h"

namespace fluovox::tools {

// Each is one file of this folder, named after it.
ExitCode run_check(const std::vector<std::string>& arguments);
ExitCode run_demo(const std::vector<std::string>& arguments);
ExitCode run_dyes(const std::vector<std::string>& arguments);
ExitCode run_fluence(const std::vector<std::string>& arguments);
ExitCode run_render(const std::vector<std::string>& arguments);
ExitCode run_info(const std::vector<std::string>& arguments);
ExitCode run_voxelize(const std::vector<std::string>& arguments);
ExitCode run_spectrum(const std::vector<std::string>& arguments);
ExitCode run_sensor(const std::vector<std::string>& arguments);
ExitCode run_diff(const std::vector<std::string>& arguments);

}  // namespace fluovox::tools
