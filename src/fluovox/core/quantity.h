#pragma once

#include <string>
#include <string_view>

namespace fluovox {

/// Kinds of physical quantity that users write with a unit, and the unit each has inside the code.
enum class Dimension {
    Length,         ///< um:         nm um mm cm m (and "µm")
    Wavelength,     ///< nm:         as Length
    Power,          ///< W:          nW uW mW W
    Concentration,  ///< umol/L:     pM nM uM mM M, mol/L and its parts
    PerLength,      ///< 1/um:       /m /cm /mm /um
    Extinction,     ///< 1/(M cm):   /M/cm
    Radiance,       ///< W/m2/sr:    W/m2/sr
    Angle,          ///< rad:        deg rad
    Time,           ///< s:          us ms s
};

/// `text` ("0.25 um", "20 /mm", "5uM") as a number in the dimension's own unit above.
/// Throws std::invalid_argument whose message says what is wrong and gives an example; it does not name the key.
double parse_quantity(std::string_view text, Dimension dimension);

/// An example of a well-written quantity of that kind, for messages: `6.5 um`.
std::string example_quantity(Dimension dimension, double number);

/// What the dimension is called in messages: "length", "power" ...
std::string_view dimension_name(Dimension dimension);

/// The names of its units that are typed without effort: "um, nm, mm".
std::string unit_names(Dimension dimension);

/// `value` (in the dimension's own unit) as a short text that `parse_quantity` reads back exactly.
std::string format_quantity(double value, Dimension dimension);

}  // namespace fluovox
