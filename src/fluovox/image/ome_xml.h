#pragma once

// Internal: the text in the first page of an OME-TIFF. Not installed.

#include "fluovox/image/stack_info.h"

#include <string>

namespace fluovox {

/// OME-XML of schema 2016-06, in ASCII. The scene and our own description of the stack are its annotations.
std::string ome_xml(const StackInfo& info);

/// Our own description (`to_json`) and the scene, out of such a text; empty where it is not one of ours.
std::string stack_json_in(const std::string& xml);
std::string scene_json_in(const std::string& xml);

}  // namespace fluovox
