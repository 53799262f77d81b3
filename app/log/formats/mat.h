// SPDX-License-Identifier: MIT
// What MATLAB saves, up to version 7.
#pragma once

#include <memory>
#include <string_view>

#include "../bytes.h"
#include "../recording.h"

namespace gyrobudget::inline v0::log {

/// MAT-files of versions 5, 6 and 7, of either byte order. Version 7.3 is HDF5, see hdf5.h.
[[nodiscard]] bool is_mat(std::string_view head);

/// Structs, and the arrays of the top level; see ArrayRecording. Data are inflated on the way, a block at a time. What
/// is no matrix of real numbers is named in the notes.
[[nodiscard]] std::unique_ptr<Recording> open_mat(std::shared_ptr<const Bytes> bytes);

}  // namespace gyrobudget::inline v0::log
