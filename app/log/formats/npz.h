// SPDX-License-Identifier: MIT
// What NumPy saves, beyond the logs of binary.h.
#pragma once

#include <memory>
#include <string_view>

#include "../bytes.h"
#include "../recording.h"

namespace gyrobudget::inline v0::log {

/// A zip archive of .npy.
[[nodiscard]] bool is_npz(std::string_view head);
/// Any other zip archive.
[[nodiscard]] bool is_other_zip(std::string_view head);
/// A .npy that read_log refuses and this reads: in Fortran order, of integers, halves, or big-endian numbers.
[[nodiscard]] bool is_other_npy(std::string_view head);

/// The arrays as those of the top level; see ArrayRecording. What is no array of real numbers is named in the notes. Of
/// an archive that was cut, whole arrays are there.
[[nodiscard]] std::unique_ptr<Recording> open_npz(std::shared_ptr<const Bytes> bytes);
/// One array of that name: "array".
/// @throws InputError for a header that is none, or other than real numbers.
[[nodiscard]] std::unique_ptr<Recording> open_other_npy(std::shared_ptr<const Bytes> bytes);

}  // namespace gyrobudget::inline v0::log
