// SPDX-License-Identifier: MIT
#include "scene.h"

#include "gyrobudget/estimation/navigation/alignment.h"
#include "gyrobudget/estimation/navigation/errors.h"
#include "gyrobudget/vehicle/earth/frames.h"
#include "gyrobudget/vehicle/earth/gravity.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <utility>

namespace gyrobudget::inline v0::budget {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kSway = 1e-3;       // of a vehicle that is said to rest [m/s]
constexpr double kRestInterval = 1;  // [s]
constexpr double kStepsOfAScene = 200;
constexpr double kLongestScene = 3.2e7;          // [s]
constexpr double kFinest = 1e-5;                 // no prior of alignment is finer [rad]
constexpr double kLinear = 10 * earth::kDegree;  // nor coarser, where it need not be

const navigation::SelfAlignment* self_alignment(const navigation::Scenario& scenario) {
  return std::get_if<navigation::SelfAlignment>(&scenario.alignment.attitude);
}

// Mid-step attitude is that of the step's mean to (turn of a step)^2/24: 1 %.
constexpr double kTurnOfAStep = 0.5;  // [rad]

double fastest_turn(const earth::Trajectory& trajectory) {
  constexpr int kInstants = 1000;
  double fastest = 0;
  for (int i = 0; i <= kInstants; ++i)
    fastest = std::max(fastest, trajectory.at(trajectory.duration() * i / kInstants).sensed.w_ib_b.norm());
  return fastest;
}

double covariance_step(const BudgetQuestion& question, double length, const earth::Trajectory& trajectory) {
  if (question.step > 0) return question.step;
  const double step =
      std::min(length / kStepsOfAScene, kTurnOfAStep / (fastest_turn(trajectory) + earth::wgs84::kEarthRate));
  return length <= 3600 ? std::min(step, 1.0) : step;
}

class Builder {
 public:
  Builder(const navigation::Scenario& scenario, const earth::Trajectory& trajectory, const BudgetQuestion& question)
      : scenario_(scenario), trajectory_(trajectory), question_(question) {
    if (const auto* self = self_alignment(scenario)) pad_ = self->duration;
    length_ = pad_ + trajectory.duration();
    if (!(length_ <= kLongestScene))
      throw navigation::SetupError(
          fmt::format("a scene of {:g} s, expected at most {:g} s, a year", length_, kLongestScene));
    const earth::Geodetic site = scenario.site ? *scenario.site : earth::to_geodetic(trajectory.at(0).pose.p_eb_e);
    C_enu_ = earth::LocalFrame::east_north_up(site).C_el();
    C_launch_ = earth::LocalFrame::launch_plane(site, scenario.azimuth).C_el();
  }

  BudgetScene operator()() {
    plan_start();
    plan_fixes();
    initial_errors();
    BudgetScene scene{.timeline = timeline(), .C_enu = C_enu_, .C_launch = C_launch_, .initial = true_start_};
    scene.no_heading = no_heading_;
    check_range(scene, scenario_.sensor.gyro.range, navigation::Carrier::gyro);
    if (scenario_.sensor.accelerometer)
      check_range(scene, scenario_.sensor.accelerometer->range, navigation::Carrier::accelerometer);
    if (const auto* self = self_alignment(scenario_)) {
      scene.self_alignment = true;
      if (self->heading) scene.heading_sigma = initial_.heading;
    }
    add_sources(scene);
    if (!scene.timeline.fixes().empty() || scene.self_alignment) design(scene);
    return scene;
  }

 private:
  [[nodiscard]] bool aided() const { return !fixes_.empty(); }

  [[nodiscard]] navigation::SensorStates::Options state_options() const {
    navigation::SensorStates::Options options = scenario_.states;
    options.scene_length = length_;
    options.step = question_.imu_interval;
    return options;
  }

  // --- Fixes ---
  void plan_fixes() {
    for (std::size_t i = 0; i < scenario_.aids.size(); ++i) {
      const navigation::Aid& aid = scenario_.aids[i];
      check(aid);
      if (!aid.used || (aid.kind == navigation::Aid::Kind::rest && pad_ > 0)) continue;
      plan(aid, static_cast<int>(i), std::max(aid.valid.from, 0.0), std::min(aid.valid.to, trajectory_.duration()));
    }
    if (pad_ > 0) rest_on_the_pad();
  }

  void plan(const navigation::Aid& aid, int number, double from, double to) {
    navigation::FixPlan plan{from, to, 1 / aid.rate, {}};
    for (const navigation::Span& outage : aid.outages) plan.outages.emplace_back(outage.from, outage.to);
    const bool starts =
        std::ranges::any_of(starts_, [&](const auto& fix) { return navigation::aid_of(fix) == number; });
    for (const double t : navigation::fix_times(plan))
      if (!starts || t > -pad_) fixes_.push_back({t, fix(aid, number, t)});  // a fix is used once
  }

  // The fixes that the start is taken from. Of an aid that the filter never sees, its sigma is all that counts.
  void plan_start() {
    const navigation::AlignmentPlan& a = scenario_.alignment;
    for (const navigation::FromAid* from :
         {std::get_if<navigation::FromAid>(&a.position), std::get_if<navigation::FromAid>(&a.velocity),
          std::get_if<navigation::FromAid>(&a.attitude)}) {
      if (from == nullptr) continue;
      const navigation::Aid& aid = scenario_.aids.at(from->aid);
      check(aid);
      if (pad_ == 0 && !holds(aid, 0))
        throw navigation::SetupError(fmt::format(
            "{}: the start is taken from it, and at 0 s it gives no fix: mend its valid span or outages, or give the start",
            aid.name));
      if (aid.used) starts_.push_back({-pad_, fix(aid, static_cast<int>(from->aid), 0)});
    }
  }

  static bool holds(const navigation::Aid& aid, double t) { return aid.valid.holds(t) && !in_outage(aid, t); }
  static bool in_outage(const navigation::Aid& aid, double t) {
    return std::ranges::any_of(aid.outages, [t](const navigation::Span& outage) { return outage.holds(t); });
  }
  template <typename Given>
  [[nodiscard]] bool taken(const Given& given) const {
    const auto* from = std::get_if<navigation::FromAid>(&given);
    return from != nullptr && scenario_.aids.at(from->aid).used;
  }

  void rest_on_the_pad() {
    const auto rest = std::find_if(scenario_.aids.begin(), scenario_.aids.end(), [](const navigation::Aid& aid) {
      return aid.used && aid.kind == navigation::Aid::Kind::rest;
    });
    const bool given = rest != scenario_.aids.end();
    rest_ = given ? static_cast<int>(rest - scenario_.aids.begin()) : static_cast<int>(scenario_.aids.size());
    const Vector3d sigma = given ? rest->sigma : Vector3d::Constant(kSway);
    const double interval = given ? 1 / rest->rate : kRestInterval;
    const auto in_use = [&](double t) {  // a span from 0 s on is one from the scene's start on
      if (!given) return true;
      return t <= rest->valid.to && (t >= rest->valid.from || rest->valid.from <= 0) && !in_outage(*rest, t);
    };
    for (const double t : navigation::fix_times({-pad_ + interval, 0, interval, {}}))
      if (in_use(t))
        fixes_.push_back({t, navigation::VelocityFix{Vector3d::Zero(), sigma, C_enu_, Vector3d::Zero(), rest_}});
  }

  [[nodiscard]] std::variant<navigation::PositionFix, navigation::VelocityFix, navigation::HeightFix,
                             navigation::AttitudeFix>
  fix(const navigation::Aid& aid, int number, double t) const {
    const earth::TrajectoryPoint truth = trajectory_.at(t);
    const Matrix3d C = truth.pose.q_eb.toRotationMatrix();
    const earth::Geodetic at = earth::to_geodetic(truth.pose.p_eb_e);
    const Matrix3d axes = earth::C_e_enu(at.latitude, at.longitude);
    const Vector3d w_eb_b = truth.sensed.w_ib_b - C.transpose() * Vector3d(0, 0, earth::wgs84::kEarthRate);
    switch (aid.kind) {
      case navigation::Aid::Kind::position:
        return navigation::PositionFix{truth.pose.p_eb_e + C * aid.lever_arm, aid.sigma, axes, aid.lever_arm, number};
      case navigation::Aid::Kind::height:
        return navigation::HeightFix{at.height, aid.sigma[0], number};
      case navigation::Aid::Kind::attitude:
        return navigation::AttitudeFix{truth.pose.q_eb, aid.sigma, number};
      case navigation::Aid::Kind::velocity:
      case navigation::Aid::Kind::rest:
        if (aid.kind == navigation::Aid::Kind::rest) check_rest(aid, truth.pose.v_eb_e.norm(), t);
        return navigation::VelocityFix{truth.pose.v_eb_e + C * w_eb_b.cross(aid.lever_arm), aid.sigma, axes,
                                       aid.lever_arm, number};
    }
    throw std::logic_error("an aid of no known kind");
  }

  // Zero velocity in flight would aid as no device can.
  static void check_rest(const navigation::Aid& aid, double speed, double t) {
    constexpr double kSigmas = 5;
    if (speed > kSigmas * aid.sigma.maxCoeff())
      throw navigation::SetupError(fmt::format(
          "{}: at {:g} s, where it says rest, the trajectory moves with {:.3g} m/s; end it before, as in until: 8 s",
          aid.name, t, speed));
  }

  // --- Start ---
  void initial_errors() {
    const navigation::AlignmentPlan& a = scenario_.alignment;
    initial_.position = a.position_sigma.value_or(of_aid(a.position));
    initial_.velocity = a.velocity_sigma.value_or(of_aid(a.velocity));
    const auto* self = self_alignment(scenario_);
    const auto* from = std::get_if<navigation::FromAid>(&a.attitude);
    const double of_master = from ? navigation::total_sigma(scenario_.aids.at(from->aid)).maxCoeff() : 0;
    initial_.level = a.level_sigma.value_or(of_master);
    initial_.heading = a.heading_sigma.value_or(of_master);
    true_start_ = initial_;
    if (taken(a.position)) true_start_.position.setZero();
    if (taken(a.velocity)) true_start_.velocity.setZero();
    if (taken(a.attitude)) true_start_.level = true_start_.heading = 0;
    if (self) coarse(*self);
  }

  // A coarse alignment of the true means: what a filter that starts from it is told, and what of it errors of the
  // sensors cause.
  void coarse(const navigation::SelfAlignment& self) {
    const earth::TrajectoryPoint start = trajectory_.at(0);
    const Matrix3d C_be = start.pose.q_eb.toRotationMatrix().transpose();
    const earth::Geodetic at = earth::to_geodetic(start.pose.p_eb_e);
    navigation::AlignmentOptions options;
    options.sensor = scenario_.sensor;
    options.interval = question_.imu_interval;
    options.latitude = at.latitude;
    const Matrix3d C_en = earth::C_e_ned(at.latitude, at.longitude);
    if (self.heading)
      options.heading =
          navigation::heading_of(Eigen::Quaterniond(C_en).conjugate() * start.pose.q_eb, initial_.heading);
    const navigation::Alignment found =
        navigation::align(navigation::StaticMeans{-(C_be * earth::normal_gravity(start.pose.p_eb_e)),
                                                  C_be * Vector3d(0, 0, earth::wgs84::kEarthRate), self.duration},
                          options);
    const Vector3d sigma = found.sigma();
    const auto trusted_less = [](double one) {
      return std::clamp(BudgetScene::kCoarse * one, kFinest, std::max(one, kLinear));
    };
    // As means are true minus sensed.
    alignment_ = -(earth::C_e_enu(at.latitude, at.longitude) * found.by_means);
    if (!scenario_.alignment.level_sigma) initial_.level = trusted_less(sigma.head<2>().maxCoeff());
    true_start_.level = 0;
    if (self.heading) return;
    initial_.heading = trusted_less(sigma.z());
    true_start_.heading = found.heading_observable ? 0 : initial_.heading;
    if (!found.heading_observable) no_heading_ = found.message;
  }

  template <typename Given>
  [[nodiscard]] Vector3d of_aid(const Given& given) const {
    const auto* from = std::get_if<navigation::FromAid>(&given);
    return from ? navigation::total_sigma(scenario_.aids.at(from->aid)) : Vector3d::Zero();
  }

  [[nodiscard]] Timeline timeline() const {
    Timeline::Options options;
    options.step = covariance_step(question_, length_, trajectory_);
    options.pad = pad_;
    options.report = question_.at;
    for (int i = 0; i < question_.growth_points; ++i)
      options.report.push_back(-pad_ + length_ * i / question_.growth_points);
    return {trajectory_, fixes_, options};
  }

  // Linear covariance knows nothing of a sensor that saturates.
  static void check_range(BudgetScene& scene, const std::optional<double>& range, navigation::Carrier carrier) {
    if (!range) return;
    const bool gyro = carrier == navigation::Carrier::gyro;
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      double peak = 0, from = 0;
      for (const auto& step : scene.timeline.steps()) {
        const double u = std::abs((gyro ? step.input.w_ib_b : step.input.f_ib_b)[axis]);
        if (u >= *range && peak < *range) from = step.from;
        peak = std::max(peak, u);
      }
      if (peak < *range) continue;
      scene.out_of_range.push_back({carrier, static_cast<int>(axis), from, peak, *range});
    }
  }

  // --- Sources ---
  void add_sources(BudgetScene& scene) const {
    auto [sources, left_out] = sensor_sources(scenario_.sensor, state_options());
    scene.sources = std::move(sources);
    scene.left_out = std::move(left_out);
    for (Source& source : initial_sources(true_start_, C_enu_)) scene.sources.push_back(std::move(source));
    for (std::size_t i = 0; i < scenario_.aids.size(); ++i)
      if (scenario_.aids[i].used) add_aid(scene, scenario_.aids[i], static_cast<int>(i));
    scene.aids.starts = starts_;
    if (rest_ == static_cast<int>(scenario_.aids.size())) scene.sources.push_back(white("aid.rest", rest_));
    if (question_.gravity > 0) scene.sources.push_back(gravity_error(question_.gravity));
    if (question_.deflection > 0) scene.sources.push_back(deflection_of_the_vertical(question_.deflection));
    if (!question_.earth_rate_compensated) scene.sources.push_back(uncompensated_earth_rate());
  }

  static Source white(std::string name, int aid) {
    Source source;
    source.name = std::move(name);
    source.initial = navigation::StateMatrix(0, 0);
    source.aid = aid;
    return source;
  }

  // The part that an aid's error has in the start, of whose terms `source` has `initial`.
  void add_start(const Timeline& timeline, int number, Source& source) const {
    for (const navigation::PlannedFix& fix : starts_) {
      if (navigation::aid_of(fix) != number) continue;
      const navigation::StartFromFix start = navigation::start_from(fix, timeline.at(timeline.start()), source.model);
      if (source.aid == number) source.core += start.white;
      if (source.model.terms.empty()) continue;
      const Eigen::Matrix<double, navigation::kCoreStates, Eigen::Dynamic> cross = start.by_terms * source.initial;
      source.core += cross * start.by_terms.transpose();
      if (source.cross.cols() == 0)
        source.cross = cross;
      else
        source.cross += cross;
    }
  }

  void add_aid(BudgetScene& scene, const navigation::Aid& aid, int number) const {
    const std::string name = fmt::format("aid.{}", aid.name);
    add_start(scene.timeline, number, scene.sources.emplace_back(white(name, number)));
    const navigation::AidTerms terms = navigation::aid_terms(aid, number);
    for (const auto& [part, effect, correlated] : {std::tuple{"bias", navigation::Effect::bias, false},
                                                   {"correlated", navigation::Effect::bias, true},
                                                   {"lever_arm", navigation::Effect::lever_arm, false},
                                                   {"time_tag", navigation::Effect::time_tag, false}}) {
      Source source;
      source.name = fmt::format("{}.{}", name, part);
      std::vector<double> variances;
      for (std::size_t k = 0; k < terms.terms.size(); ++k)
        if (terms.terms[k].effect == effect && (terms.terms[k].walk > 0) == correlated) {
          source.model.terms.push_back(terms.terms[k]);
          variances.push_back(terms.variances[k]);
        }
      if (variances.empty()) continue;
      source.initial = diagonal(variances);
      add_start(scene.timeline, number, source);
      scene.sources.push_back(std::move(source));
    }
    append(scene.aids, terms);
  }

  static navigation::StateMatrix diagonal(const std::vector<double>& variances) {
    const auto n = static_cast<Eigen::Index>(variances.size());
    navigation::StateMatrix P = navigation::StateMatrix::Zero(n, n);
    for (Eigen::Index i = 0; i < n; ++i) P(i, i) = variances[static_cast<std::size_t>(i)];
    return P;
  }

  static void append(MonteCarlo::AidErrors& aids, const navigation::AidTerms& terms) {
    const auto old = aids.initial.rows(), more = static_cast<Eigen::Index>(terms.variances.size());
    navigation::StateMatrix P = navigation::StateMatrix::Zero(old + more, old + more);
    P.topLeftCorner(old, old) = aids.initial;
    P.bottomRightCorner(more, more) = diagonal(terms.variances);
    aids.initial = P;
    aids.model.terms.insert(aids.model.terms.end(), terms.terms.begin(), terms.terms.end());
  }

  // --- Filter ---
  void design(BudgetScene& scene) const {
    const navigation::SensorStates states = navigation::sensor_states(scenario_.sensor, state_options());
    Design design;
    design.model = states.model;
    design.model.terms.insert(design.model.terms.end(), scene.aids.model.terms.begin(), scene.aids.model.terms.end());
    const auto n = states.initial.rows(), m = scene.aids.initial.rows();
    navigation::StateMatrix terms = navigation::StateMatrix::Zero(n + m, n + m);
    terms.topLeftCorner(n, n) = states.initial;
    terms.bottomRightCorner(m, m) = scene.aids.initial;
    design.initial = navigation::initial_covariance(initial_core(told(), C_enu_), terms);
    add_start(scene, design.initial);
    design.alignment = alignment_;
    scene.design = std::move(design);
  }

  // Sigmas that a scene gives beside an aid are what its filter is told; the truth is the aid's.
  [[nodiscard]] bool told_sigma(const navigation::PlannedFix& fix) const {
    const navigation::AlignmentPlan& a = scenario_.alignment;
    if (std::holds_alternative<navigation::PositionFix>(fix.fix)) return a.position_sigma.has_value();
    if (std::holds_alternative<navigation::VelocityFix>(fix.fix)) return a.velocity_sigma.has_value();
    return a.level_sigma.has_value() || a.heading_sigma.has_value();
  }
  [[nodiscard]] InitialErrors told() const {
    InitialErrors errors = initial_;
    for (const navigation::PlannedFix& fix : starts_) {
      if (told_sigma(fix)) continue;
      if (std::holds_alternative<navigation::PositionFix>(fix.fix)) errors.position.setZero();
      if (std::holds_alternative<navigation::VelocityFix>(fix.fix)) errors.velocity.setZero();
      if (std::holds_alternative<navigation::AttitudeFix>(fix.fix)) errors.level = errors.heading = 0;
    }
    return errors;
  }
  void add_start(const BudgetScene& scene, navigation::StateMatrix& P0) const {
    const Eigen::Index m = scene.aids.initial.rows(), first = P0.rows() - m;
    for (const navigation::PlannedFix& fix : starts_) {
      if (told_sigma(fix)) continue;
      const navigation::StartFromFix start =
          navigation::start_from(fix, scene.timeline.at(scene.timeline.start()), scene.aids.model);
      const Eigen::Matrix<double, navigation::kCoreStates, Eigen::Dynamic> cross = start.by_terms * scene.aids.initial;
      P0.topLeftCorner<navigation::kCoreStates, navigation::kCoreStates>() +=
          start.white + navigation::CoreMatrix(cross * start.by_terms.transpose());
      P0.block(0, first, navigation::kCoreStates, m) += cross;
      P0.block(first, 0, m, navigation::kCoreStates) += cross.transpose();
    }
  }

  const navigation::Scenario& scenario_;
  const earth::Trajectory& trajectory_;
  const BudgetQuestion& question_;
  double pad_ = 0, length_ = 0;
  Matrix3d C_enu_, C_launch_;
  std::vector<navigation::PlannedFix> fixes_;
  std::vector<navigation::PlannedFix> starts_;  ///< that the start is taken from
  int rest_ = -1;
  InitialErrors initial_;     ///< that a filter is told
  InitialErrors true_start_;  ///< that no sensor and no aid causes
  std::optional<AlignmentGain> alignment_;
  std::string no_heading_;
};

// Traces of position, velocity and attitude.
Vector3d totals(const navigation::CoreMatrix& P) {
  return {P.block<3, 3>(navigation::kPosition, navigation::kPosition).trace(),
          P.block<3, 3>(navigation::kVelocity, navigation::kVelocity).trace(),
          P.block<3, 3>(navigation::kAttitude, navigation::kAttitude).trace()};
}

}  // namespace

BudgetQuestion question_of(const navigation::Scenario& scenario, double imu_interval) {
  BudgetQuestion q;
  q.imu_interval = imu_interval;
  q.gravity = scenario.gravity_sigma;
  q.deflection = scenario.deflection_sigma;
  q.earth_rate_compensated = scenario.filter.strapdown.earth_rate_in_attitude;
  return q;
}

BudgetScene budget_scene(const navigation::Scenario& scenario, const earth::Trajectory& trajectory,
                         const BudgetQuestion& question) {
  return Builder(scenario, trajectory, question)();
}

std::vector<Negligible> leave_out(BudgetScene& scene, const FrozenGains& gains, std::span<const double> times,
                                  double tolerance) {
  if (!(tolerance >= 0 && tolerance < 1))
    throw navigation::SetupError(fmt::format("tolerance is {}, expected 0 to below 1", tolerance));
  const std::size_t n = scene.sources.size();
  const auto columns = static_cast<Eigen::Index>(3 * times.size());
  Eigen::MatrixXd variance(static_cast<Eigen::Index>(n), columns);  // of each source in every total
  for (std::size_t t = 0; t < times.size(); ++t) {
    const Adjoint back = adjoint(scene.timeline, gains, times[t]);
    for (std::size_t s = 0; s < n; ++s)
      variance.block<1, 3>(static_cast<Eigen::Index>(s), static_cast<Eigen::Index>(3 * t)) =
          totals(state_response(back, scene.timeline, scene.sources[s])).transpose();
  }
  if (!variance.allFinite()) return {};
  // Sigma falls by at most `tolerance` of itself where variance falls by 1 - (1 - tolerance)^2.
  const Eigen::RowVectorXd total = variance.colwise().sum();
  const Eigen::RowVectorXd allowed = tolerance * (2 - tolerance) * total;
  std::vector<std::size_t> order(n);
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto largest_share = [&](std::size_t s) {
    const auto row = variance.row(static_cast<Eigen::Index>(s));
    return (total.array() > 0).select(row.array() / total.array(), 0).maxCoeff();
  };
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return largest_share(a) < largest_share(b); });
  std::vector<Negligible> left_out;
  std::vector<bool> gone(n, false);
  Eigen::RowVectorXd sum = Eigen::RowVectorXd::Zero(columns);
  for (const std::size_t s : order) {
    const auto row = variance.row(static_cast<Eigen::Index>(s));
    if (((sum + row).array() > allowed.array() && row.array() > 0).any()) break;
    sum += row;
    gone[s] = true;
    double position = 0;
    for (std::size_t t = 0; t < times.size(); ++t)
      position = std::max(position, std::sqrt(row[static_cast<Eigen::Index>(3 * t)]));
    left_out.push_back({scene.sources[s].name, position, row.isZero(0) ? 0 : largest_share(s)});
  }
  std::size_t next = 0;
  std::erase_if(scene.sources, [&](const Source&) { return gone[next++]; });
  return left_out;
}

std::vector<double> shares(const Budget& budget, std::size_t i) {
  const double total = budget.total[i].block<3, 3>(navigation::kPosition, navigation::kPosition).trace();
  std::vector<double> list;
  for (const auto& line : budget.lines) {
    const double own = line.covariance[i].block<3, 3>(navigation::kPosition, navigation::kPosition).trace();
    list.push_back(total > 0 ? own / total : 0);
  }
  return list;
}

double allowed_factor(const Budget& budget, std::size_t i, std::string_view source,
                      const Eigen::Matrix<double, 3, Eigen::Dynamic>& axes, double limit) {
  const auto variance = [&](const navigation::CoreMatrix& P) {
    return (axes.transpose() * P.block<3, 3>(navigation::kPosition, navigation::kPosition) * axes).trace();
  };
  const auto line =
      std::find_if(budget.lines.begin(), budget.lines.end(), [&](const auto& one) { return one.name == source; });
  if (line == budget.lines.end()) throw std::invalid_argument(fmt::format("the budget has no source '{}'", source));
  const double own = variance(line->covariance[i]);
  const double room = limit * limit - (variance(budget.total[i]) - own);
  if (room <= 0) return 0;
  return own > 0 ? std::sqrt(room / own) : std::numeric_limits<double>::infinity();
}

}  // namespace gyrobudget::inline v0::budget
