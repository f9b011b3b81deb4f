#include "fluovox/image/ome_xml.h"

#include "fluovox/core/utf8.h"

#include <fmt/format.h>

#include <string_view>

namespace fluovox {
namespace {

constexpr const char* kStackNamespace = "fluovox/stack";
constexpr const char* kSceneNamespace = "fluovox/scene";
constexpr const char* kMicrometre = "&#181;m";

/// As XML text in ASCII; characters that XML cannot hold become question marks.
std::string escaped(std::string_view text) {
    std::string out;
    for (std::size_t at = 0; at < text.size();) {
        const char32_t c = next_character(text, at);
        if (c == '&') {
            out += "&amp;";
        } else if (c == '<') {
            out += "&lt;";
        } else if (c == '>') {
            out += "&gt;";
        } else if (c == '"') {
            out += "&quot;";
        } else if (c >= 0x7F) {
            out += c == 0xFFFE || c == 0xFFFF || (c >= 0xD800 && c < 0xE000)
                       ? "?"
                       : fmt::format("&#{};", static_cast<std::uint32_t>(c));
        } else if (c < ' ' && c != '\n' && c != '\t') {
            out += '?';
        } else {
            out += static_cast<char>(c);
        }
    }
    return out;
}

std::string unescaped(std::string_view text) {
    std::string out;
    for (std::size_t at = 0; at < text.size(); ++at) {
        const std::size_t end = text[at] == '&' ? text.find(';', at) : std::string_view::npos;
        if (end == std::string_view::npos) {
            out += text[at];
            continue;
        }
        const std::string_view name = text.substr(at + 1, end - at - 1);
        if (name == "amp") out += '&';
        if (name == "lt") out += '<';
        if (name == "gt") out += '>';
        if (name == "quot") out += '"';
        if (name.substr(0, 1) == "#") append_utf8(out, static_cast<char32_t>(std::stoul(std::string(name.substr(1)))));
        at = end;
    }
    return out;
}

std::string annotation_in(const std::string& xml, const char* name) {
    const std::size_t begin = xml.find(fmt::format("Namespace=\"{}\"", name));
    if (begin == std::string::npos) return {};
    constexpr std::string_view kOpen = "<Value>";
    const std::size_t open = xml.find(kOpen, begin);
    const std::size_t close = xml.find("</Value>", begin);
    if (open == std::string::npos || close == std::string::npos || close < open) return {};
    return unescaped(std::string_view(xml).substr(open + kOpen.size(), close - open - kOpen.size()));
}

std::string channel_xml(const StackChannel& channel, std::size_t index) {
    // Colours are signed 32-bit numbers, RGBA.
    const auto color = static_cast<std::int32_t>((channel.rgb << 8U) | 0xFFU);
    std::string xml = fmt::format(
        R"(      <Channel ID="Channel:0:{}" Name="{}" SamplesPerPixel="1" AcquisitionMode="SPIM" ContrastMethod="Fluorescence")"
        R"( Color="{}")",
        index, escaped(channel.name), color);
    if (!channel.dye.empty()) xml += fmt::format(R"( Fluor="{}")", escaped(channel.dye));
    if (channel.excitation_nm > 0)
        xml += fmt::format(R"( ExcitationWavelength="{}" ExcitationWavelengthUnit="nm")", channel.excitation_nm);
    if (channel.emission_nm > 0)
        xml += fmt::format(R"( EmissionWavelength="{:.6g}" EmissionWavelengthUnit="nm")", channel.emission_nm);
    return xml + "/>\n";
}

std::string planes_xml(const StackInfo& info) {
    std::string xml;
    for (int plane = 0; plane < info.planes; ++plane) {
        const Vec3 p = info.positions_um[static_cast<std::size_t>(plane)];
        for (std::size_t channel = 0; channel < info.channels.size(); ++channel) {
            xml += fmt::format(R"(      <Plane TheZ="{}" TheC="{}" TheT="0")", plane, channel);
            if (info.exposure_s > 0) xml += fmt::format(R"( ExposureTime="{}" ExposureTimeUnit="s")", info.exposure_s);
            xml += fmt::format(
                R"( PositionX="{}" PositionXUnit="{}" PositionY="{}" PositionYUnit="{}" PositionZ="{}" PositionZUnit="{}"/>)"
                "\n",
                p.x, kMicrometre, p.y, kMicrometre, p.z, kMicrometre);
        }
    }
    return xml;
}

std::string pixels_xml(const StackInfo& info) {
    const bool counts = info.type == SampleType::UInt16;
    std::string xml = fmt::format(
        R"(    <Pixels ID="Pixels:0" DimensionOrder="XYCZT" Type="{}" SignificantBits="{}" Interleaved="false" BigEndian="false")"
        R"( SizeX="{}" SizeY="{}" SizeC="{}" SizeZ="{}" SizeT="1")",
        counts ? "uint16" : "float", counts ? info.significant_bits : 32, info.width, info.height, info.channels.size(),
        info.planes);
    xml += fmt::format(
        R"( PhysicalSizeX="{0}" PhysicalSizeXUnit="{2}" PhysicalSizeY="{0}" PhysicalSizeYUnit="{2}" PhysicalSizeZ="{1}")"
        R"( PhysicalSizeZUnit="{2}">)"
        "\n",
        info.pixel_um, info.step_um, kMicrometre);
    for (std::size_t i = 0; i < info.channels.size(); ++i)
        xml += channel_xml(info.channels[i], i);
    xml += fmt::format("      <TiffData IFD=\"0\" PlaneCount=\"{}\"/>\n",
                       static_cast<std::size_t>(info.planes) * info.channels.size());
    return xml + planes_xml(info) + "    </Pixels>\n";
}

std::string describe(const StackInfo& info) {
    std::string text = info.quantity + (info.unit.empty() ? "" : ", " + info.unit);
    if (info.blur_um > 0)
        text += fmt::format("; blurred with a Gaussian of {:.3g} um full width in place of diffraction", info.blur_um);
    return text;
}

std::string comment_xml(int index, const char* name, const std::string& text) {
    return fmt::format(
        "    <CommentAnnotation ID=\"Annotation:{}\" Namespace=\"{}\">\n      <Value>{}</Value>\n"
        "    </CommentAnnotation>\n",
        index, name, escaped(text));
}

}  // namespace

std::string ome_xml(const StackInfo& info) {
    std::string xml =
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
        "<!-- Warning: this comment is an OME-XML metadata block, which contains crucial dimensional parameters and "
        "other important metadata. Please edit cautiously (if at all), and back up the original data before doing so. "
        "-->\n"
        "<OME xmlns=\"http://www.openmicroscopy.org/Schemas/OME/2016-06\" "
        "xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\" "
        "xsi:schemaLocation=\"http://www.openmicroscopy.org/Schemas/OME/2016-06 "
        "http://www.openmicroscopy.org/Schemas/OME/2016-06/ome.xsd\" Creator=\"fluovox\">\n";
    const bool objective = info.numerical_aperture > 0;
    if (objective) {
        xml += fmt::format(
            "  <Instrument ID=\"Instrument:0\">\n    <Objective ID=\"Objective:0\" LensNA=\"{}\"/>\n  </Instrument>\n",
            info.numerical_aperture);
    }
    xml += fmt::format("  <Image ID=\"Image:0\" Name=\"{}\">\n", escaped(info.title));
    xml += fmt::format("    <Description>{}</Description>\n", escaped(describe(info)));
    if (objective) {
        xml += "    <InstrumentRef ID=\"Instrument:0\"/>\n";
        xml +=
            fmt::format("    <ObjectiveSettings ID=\"Objective:0\" RefractiveIndex=\"{}\"/>\n", info.immersion_index);
    }
    xml += pixels_xml(info);
    xml += "    <AnnotationRef ID=\"Annotation:0\"/>\n    <AnnotationRef ID=\"Annotation:1\"/>\n  </Image>\n";
    xml += "  <StructuredAnnotations>\n" + comment_xml(0, kStackNamespace, to_json(info)) +
           comment_xml(1, kSceneNamespace, info.scene_json) + "  </StructuredAnnotations>\n</OME>\n";
    return xml;
}

std::string stack_json_in(const std::string& xml) {
    return annotation_in(xml, kStackNamespace);
}

std::string scene_json_in(const std::string& xml) {
    return annotation_in(xml, kSceneNamespace);
}

}  // namespace fluovox
