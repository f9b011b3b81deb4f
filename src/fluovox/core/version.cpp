#include "fluovox/core/version.h"

namespace fluovox {

const char* version() {
    return FLUOVOX_VERSION;
}

}  // namespace fluovox
