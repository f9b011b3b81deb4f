#pragma once

#include "command.h"

namespace fluovox::tools {

// Each is one file of this folder, named after it.

}  // namespace fluovox::tools
