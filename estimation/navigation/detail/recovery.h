// SPDX-License-Identifier: MIT
// Inside navigation: from a filter that is lost back to one that is not.
#pragma once

#include "gyrobudget/estimation/navigation/navigate.h"

#include <optional>
#include <vector>

#include "lost.h"
#include "trial.h"

namespace gyrobudget::inline v0::navigation::detail {

class Recovery {
 public:
  /// The scenario must outlive it. `start` is where the filter does [s].
  Recovery(const Scenario& scenario, double start);

  /// What the filter of the run made of a fix, after which trials begin, go on or end.
  void saw(std::size_t aid, const Fix& fix, double time, const Innovation& innovation, const Filter& filter);
  /// The filter that is to go on in place of that of the run, once its fixes have agreed for long enough.
  [[nodiscard]] std::optional<Trial> found(double time);

  /// Calls work(filter) for each trial; one that leaves what can be computed ends.
  template <class Work>
  void each(const Work& work) {
    std::erase_if(trials_, [&](Trial& trial) {
      try {
        work(trial.filter);
        return false;
      } catch (const Diverged&) {
        return true;
      } catch (const earth::OutsideDomain&) {
        return true;
      }
    });
  }

  /// The spans, and status and why of a run that ends at this time [s].
  void finish(double end, Navigation& result) const;

 private:
  void try_fix(std::size_t aid, const Fix& fix, bool watched);
  void start(std::size_t aid, const Fix& fix, double time, const Innovation& innovation, const Filter& filter);
  void say_lost(double from, std::string why);

  const Scenario& scenario_;
  LostWatch watch_;
  NisLimit contradicted_{kContradicted};
  std::vector<Trial> trials_;
  std::size_t aid_ = 0;  ///< whose refused fix began the trials
  double began_ = 0;     ///< when [s]
  int disagreed_ = 0;    ///< of its fixes since, with the filter of the run
  std::vector<LostSpan> spans_;
};

}  // namespace gyrobudget::inline v0::navigation::detail
