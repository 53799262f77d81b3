// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

namespace gyrobudget::inline v0::cli {

/// A file that an option asks for.
struct Output {
  std::string option;  ///< "--plot"
  std::string path;    ///< empty: not asked for
};

/// Refuses, before any work, outputs that would destroy the input or one another, a `-` where standard output holds the
/// result already, and a picture whose format the ending does not tell.
/// @throws std::invalid_argument
void check_outputs(const std::string& input, const std::vector<Output>& outputs);

}  // namespace gyrobudget::inline v0::cli
