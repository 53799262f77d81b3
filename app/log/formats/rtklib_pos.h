// SPDX-License-Identifier: MIT
// Solutions of RTKLIB (.pos), as rtkpost, rnx2rtkp and rtkrcv write them.
#pragma once

#include <memory>
#include <string_view>

#include "../bytes.h"
#include "../recording.h"

namespace gyrobudget::inline v0::log {

/// Comment lines with %, of which one names the columns.
[[nodiscard]] bool is_rtklib_pos(std::string_view head);

/// One stream, "solution", of type "RTKLIB solution". Its clock is the one of the header's time column: "GPST", "UTC"
/// or "JST", written as a date or as week and seconds; no leap second is counted. Fields, as far as the header has
/// their columns, all in SI but for angles in deg:
///
/// - latitude, longitude and height, or height_over_geoid where a line above says that heights are geodetic; or
///   ecef_x, _y, _z; or baseline_east, _north, _up from base_latitude, base_longitude, base_height, where a
///   line "ref pos" has them;
/// - velocity_north, _east, _up, or ecef_velocity_x, _y, _z;
/// - position_sigma_east, _north, _up, or position_sigma_x, _y, _z with _xy, _yz, _zx (the square root of the
///   covariance's size, with its sign); velocity_sigma_... alike; NaN where it is 0, which RTKLIB prints for none;
/// - quality (Q: 1 fixed, 2 float, 3 SBAS, 4 DGPS, 5 single, 6 PPP, 7 dead reckoning), satellites, age, ratio.
///
/// Rows of which a cell is no number are left out, and said. Source: RTKLIB manual 2.4.2, appendix B.1.
/// @throws text::InputError where the columns of the header are not those of one of the forms.
[[nodiscard]] std::unique_ptr<Recording> open_rtklib_pos(std::shared_ptr<const Bytes> bytes);

}  // namespace gyrobudget::inline v0::log
