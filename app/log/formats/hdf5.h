// SPDX-License-Identifier: MIT
// HDF5, and what MATLAB 7.3, h5py and Octave write with it.
#pragma once

#include <memory>
#include <string_view>

#include "../bytes.h"
#include "../recording.h"

namespace gyrobudget::inline v0::log {

[[nodiscard]] bool is_matlab_73(std::string_view head);
/// The signature stands at the start, or behind 512, 1024, 2048 bytes of the user's.
[[nodiscard]] bool is_hdf5(std::string_view head);

/// The arrays of each group (in MATLAB: struct); see ArrayRecording. A data set's attribute `units` is its unit. What
/// is no matrix of real numbers is named in the notes. Links to other files are not followed.
/// @throws InputError where the library cannot open it, or is not in this build
[[nodiscard]] std::unique_ptr<Recording> open_hdf5(std::shared_ptr<const Bytes> bytes);

}  // namespace gyrobudget::inline v0::log
