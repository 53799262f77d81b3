// SPDX-License-Identifier: MIT
// What the texts of known programs mean, as a table: columns, units and clocks that their headers do not tell.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "layout.h"

namespace gyrobudget::inline v0::log {

/// What a dialect tells of a column.
struct ToldUnit {
  std::string unit;  ///< empty: nothing
  double scale = 1;  ///< units of one of its numbers
};

struct Recognised {
  std::string note;               ///< which dialect, for people
  std::vector<ToldUnit> columns;  ///< one for each of the layout
};

/// The dialect of a text, by the names in its header and what stands above it; empty for all that the table does not
/// have. Units are those of the program's own format or those that the file tells, never such as are only usual.
[[nodiscard]] std::optional<Recognised> recognise(const Layout& layout);

/// The columns of rows without a header.
struct KnownRows {
  std::vector<Heading> headings;
  std::string note;  ///< what they were taken for, for people
};
/// Of rows that say what they are: by their first cell ($VNIMU), or by a form that no others have (KITTI's 30 numbers
/// with a place, gravity and five whole numbers at their end); empty for others.
[[nodiscard]] std::optional<KnownRows> headings_of_known_rows(const Layout& layout);

/// What a line that begins so is, and how it becomes a log; empty for lines of logs.
[[nodiscard]] std::string_view advice_on(std::string_view line);

}  // namespace gyrobudget::inline v0::log
