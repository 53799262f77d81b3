// SPDX-License-Identifier: MIT
// Sentences of NMEA 0183, as GNSS receivers send them.
#pragma once

#include <memory>
#include <string_view>

#include "../bytes.h"
#include "../recording.h"

namespace gyrobudget::inline v0::log {

/// Lines that begin with $, one of which is a position or its like with a right checksum.
[[nodiscard]] bool is_nmea(std::string_view head);

/// One stream, "NMEA", with a row for each time of day that the receiver tells, from its GGA, RMC, VTG, GST and ZDA of
/// whatever talker; of sentences of one kind and time the first is taken. Its clock is UTC: the date is that of RMC or
/// ZDA, days are counted on from there, and rows before the first date count back from it. Without any date stamps
/// count from the first midnight. Dates are taken as recorded. Fields:
///
/// - latitude, longitude [deg], height_over_geoid [m], geoid_height [m] (of the geoid over the ellipsoid, as the
///   receiver has it; NaN where it tells none), quality (GGA: 0 none, 1 single, 2 differential, 4 fixed, 5 float,
///   6 dead reckoning, 7 and 8 not measured; of RMC alone 1 or 0), satellites, hdop;
/// - speed [m/s], course [deg, clockwise from true north; NaN where the receiver stands or tells none];
/// - position_sigma_north, _east, _up [m] of GST.
///
/// Lines with a wrong checksum are left out, and said. Source: NMEA 0183 as the receivers' manuals give it.
[[nodiscard]] std::unique_ptr<Recording> open_nmea(std::shared_ptr<const Bytes> bytes);

}  // namespace gyrobudget::inline v0::log
