#include "matching/matcher_conformance.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <set>
#include <thread>
#include <utility>
#include <vector>

#include "common/error_text.hpp"
#include "matchbox_slam/common/random.hpp"
#include "matching/match_scene.hpp"
#include "simulation/make_world.hpp"

namespace matchbox_slam {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

const Eigen::Matrix3d kPrior = prior_of(0.1, 0.06);

// --- scenes ---

// Made once, since most tests share them; never changed.

const MatchScene& rooms_scene() {
  static const MatchScene kScene = make_match_scene(make_rooms_world(3), LaserOptions{}, 12.0, 1);
  return kScene;
}

const MatchScene& random_scene() {
  static const MatchScene kScene = make_match_scene(make_random_world(4), LaserOptions{}, 12.0, 2);
  return kScene;
}

const MatchScene& loop_scene() {
  static const MatchScene kScene = make_match_scene(make_loop_world(5), LaserOptions{}, 12.0, 3);
  return kScene;
}

const MatchScene& corridor_scene() {
  static const MatchScene kScene =
      make_match_scene(make_corridor_world(6), LaserOptions{}, 12.0, 4);
  return kScene;
}

/// A scene with other points in the scan.
MatchScene with_points(const MatchScene& scene, std::vector<ScanPoint> points) {
  MatchScene changed = scene;
  changed.scan.points = std::move(points);
  return changed;
}

ScanPoint point_at(double x, double y) {
  ScanPoint point;
  point.position = {x, y};
  point.origin = Eigen::Vector2d::Zero();
  point.weight = 0.05;
  return point;
}

// --- checks ---

template <typename Number>
bool same_bits(const Number& a, const Number& b) {
  // NOLINTNEXTLINE(bugprone-suspicious-memory-comparison): bits are what is asked for
  return std::memcmp(&a, &b, sizeof(Number)) == 0;
}

bool same_bits(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) {
  // NOLINTNEXTLINE(bugprone-suspicious-memory-comparison): bits are what is asked for
  return std::memcmp(a.data(), b.data(), 9 * sizeof(double)) == 0;
}

bool same_bits(const Pose2& a, const Pose2& b) {
  return same_bits(a.x, b.x) && same_bits(a.y, b.y) && same_bits(a.theta, b.theta);
}

bool same_bits(const MatchResult& a, const MatchResult& b) {
  bool same = same_bits(a.map_from_base, b.map_from_base) &&
              same_bits(a.covariance, b.covariance) && same_bits(a.score, b.score) &&
              a.status == b.status && a.candidates == b.candidates &&
              same_bits(a.rival_share, b.rival_share) &&
              same_bits(a.searched_map_from_base(), b.searched_map_from_base()) &&
              a.proof.has_value() == b.proof.has_value() &&
              a.unconstrained_directions.size() == b.unconstrained_directions.size();
  if (same && a.proof) {
    same = same_bits(a.proof->best_score, b.proof->best_score) &&
           same_bits(a.proof->remaining_bound, b.proof->remaining_bound);
  }
  for (std::size_t i = 0; same && i < a.unconstrained_directions.size(); ++i) {
    same = a.unconstrained_directions[i] == b.unconstrained_directions[i];
  }
  return same;
}

/// What holds for every answer, whatever was asked.
void expect_sound(const MatchProblem& problem, const MatchResult& result) {
  SCOPED_TRACE(std::string("status ") + to_string(result.status));
  EXPECT_GE(result.score, 0.0);
  EXPECT_LE(result.score, 1.0);
  if (!result.accepted()) {
    EXPECT_TRUE(same_bits(result.map_from_base, problem.predicted_map_from_base))
        << "a rejected match returns the predicted pose";
    EXPECT_TRUE(same_bits(result.covariance, problem.prior_covariance))
        << "a rejected match returns the prior's covariance";
    return;
  }
  EXPECT_TRUE(result.map_from_base.is_finite());
  EXPECT_EQ(result.map_from_base.theta, wrap_angle(result.map_from_base.theta));
  ASSERT_TRUE(result.covariance.allFinite());
  const double scale = result.covariance.cwiseAbs().maxCoeff();
  EXPECT_TRUE((result.covariance - result.covariance.transpose()).isZero(1e-9 * scale));
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(result.covariance);
  EXPECT_GE(solver.eigenvalues().minCoeff(), -1e-9 * scale) << "covariance is not one";
  for (const Eigen::Vector2d& direction : result.unconstrained_directions) {
    EXPECT_NEAR(direction.norm(), 1.0, 1e-6);
  }
  EXPECT_LE(result.unconstrained_directions.size(), 2U);
}

/// Asks and checks what holds for every answer.
MatchResult ask(const ScanMatcher& matcher, const MatchProblem& problem) {
  MatchResult result = matcher.match(problem);
  expect_sound(problem, result);
  return result;
}

bool searches(const MatchResult& result) { return result.candidates > 1; }

/// A matcher that searches finds the truth; any other says how far off it may be.
void expect_found(const MatchResult& result, const Pose2& truth, double limit_xy,
                  double limit_theta) {
  ASSERT_TRUE(result.accepted()) << to_string(result.status);
  const Eigen::Vector3d error = shift_between(truth, result.map_from_base);
  if (searches(result)) {
    EXPECT_LE(error.head<2>().norm(), limit_xy) << "m off; score " << result.score;
    EXPECT_LE(std::abs(error.z()), limit_theta) << "rad off; score " << result.score;
  }
  // Six standard deviations: no honest covariance is that unlucky, and the map has errors of its
  // own.
  EXPECT_LE(normalised_error_square(result, truth), 36.0)
      << "the error " << error.transpose() << " does not fit the covariance\n"
      << result.covariance;
}

// --- accuracy ---

void identity(const MatcherFactory& make) {
  const auto matcher = make();
  for (const MatchScene* scene : {&rooms_scene(), &random_scene(), &loop_scene()}) {
    const MatchProblem problem = scene->problem(scene->map_from_base, kPrior);
    expect_found(ask(*matcher, problem), scene->map_from_base, 0.01, 0.005);
  }
}

void expect_known_shifts_found(const MatcherFactory& make, const MatchScene& scene) {
  const auto matcher = make();
  Random random(9);
  for (std::uint64_t i = 0; i < 8; ++i) {
    const double x = random.uniform(-0.15, 0.15);
    const double y = random.uniform(-0.15, 0.15);
    const Eigen::Vector3d shift(x, y, random.uniform(-0.1, 0.1));
    SCOPED_TRACE("prediction shifted by " + std::to_string(shift.x()) + " m, " +
                 std::to_string(shift.y()) + " m, " + std::to_string(shift.z()) + " rad");
    const MatchProblem problem = scene.problem(shifted(scene.map_from_base, shift), kPrior, i);
    expect_found(ask(*matcher, problem), scene.map_from_base, 0.02, 0.01);
  }
}

void known_shifts_in_rooms(const MatcherFactory& make) {
  expect_known_shifts_found(make, rooms_scene());
}
void known_shifts_in_clutter(const MatcherFactory& make) {
  expect_known_shifts_found(make, random_scene());
}
void known_shifts_in_loop(const MatcherFactory& make) {
  expect_known_shifts_found(make, loop_scene());
}

/// Along a bare corridor nothing but the prior tells where the robot is, and the answer says so.
void keeps_prior_along_corridor(const MatcherFactory& make) {
  const auto matcher = make();
  const MatchScene& scene = corridor_scene();  // along the x axis
  for (const double along : {-0.12, 0.1}) {
    const Pose2 predicted = shifted(scene.map_from_base, {along, 0.05, 0.02});
    const MatchResult result = ask(*matcher, scene.problem(predicted, kPrior));
    ASSERT_TRUE(result.accepted()) << to_string(result.status);
    const Eigen::Vector3d error = shift_between(scene.map_from_base, result.map_from_base);
    if (searches(result)) {
      EXPECT_LE(std::abs(error.y()), 0.02);
      EXPECT_LE(std::abs(error.z()), 0.01);
      EXPECT_EQ(result.unconstrained_directions.size(), 1U) << "the corridor has one";
    }
    EXPECT_LE(error.x() * error.x(), 9.0 * result.covariance(0, 0))
        << "claims to know more along the corridor than can be known";
    for (const Eigen::Vector2d& direction : result.unconstrained_directions) {
      const Eigen::Vector2d moved = result.map_from_base.translation() - predicted.translation();
      EXPECT_LE(std::abs(direction.dot(moved)), 1e-3)
          << "moved along a direction that it calls unconstrained";
      const double variance = direction.dot(result.covariance.topLeftCorner<2, 2>() * direction);
      const double prior = direction.dot(kPrior.topLeftCorner<2, 2>() * direction);
      EXPECT_GE(variance, 0.95 * prior) << "knows more than the prior along that direction";
      EXPECT_LE(variance, 1.05 * prior) << "knows less than the prior along that direction";
    }
  }
}

// --- determinism ---

struct Question {
  const MatchScene* scene;
  Pose2 predicted;
  std::uint64_t seed;
};

std::vector<Question> questions() {
  std::vector<Question> all;
  std::uint64_t seed = 0;
  for (const MatchScene* scene : {&rooms_scene(), &random_scene(), &loop_scene()}) {
    all.push_back({scene, shifted(scene->map_from_base, {0.08, -0.05, 0.04}), ++seed});
    all.push_back({scene, shifted(scene->map_from_base, {-0.1, 0.1, -0.03}), ++seed});
  }
  return all;
}

std::vector<MatchResult> answers(const ScanMatcher& matcher, const std::vector<Question>& asked) {
  std::vector<MatchResult> results;
  for (const Question& question : asked) {
    results.push_back(
        matcher.match(question.scene->problem(question.predicted, kPrior, question.seed)));
  }
  return results;
}

void same_problem_same_bits(const MatcherFactory& make) {
  std::vector<Question> asked = questions();
  const auto matcher = make();
  const std::vector<MatchResult> first = answers(*matcher, asked);
  const std::vector<MatchResult> again = answers(*matcher, asked);
  std::reverse(asked.begin(), asked.end());
  const std::vector<MatchResult> backwards = answers(*matcher, asked);
  const std::vector<MatchResult> by_another = answers(*make(), asked);
  for (std::size_t i = 0; i < first.size(); ++i) {
    const std::size_t mirrored = first.size() - 1 - i;
    EXPECT_TRUE(same_bits(first[i], again[i])) << "depends on what was asked before";
    EXPECT_TRUE(same_bits(first[i], backwards[mirrored])) << "depends on the order of questions";
    EXPECT_TRUE(same_bits(first[i], by_another[mirrored])) << "depends on the instance";
  }
}

void two_threads_at_once(const MatcherFactory& make) {
  const std::vector<Question> asked = questions();
  const auto matcher = make();
  const std::vector<MatchResult> alone = answers(*matcher, asked);
  std::vector<std::vector<MatchResult>> together(2);
  std::vector<std::thread> threads;
  for (std::vector<MatchResult>& results : together) {
    threads.emplace_back([&matcher, &asked, &results] {
      for (int round = 0; round < 3; ++round) {
        results = answers(*matcher, asked);
      }
    });
  }
  for (std::thread& thread : threads) {
    thread.join();
  }
  for (std::size_t i = 0; i < alone.size(); ++i) {
    EXPECT_TRUE(same_bits(alone[i], together[0][i]));
    EXPECT_TRUE(same_bits(alone[i], together[1][i]));
  }
}

// --- hostile scans ---

void empty_scan(const MatcherFactory& make) {
  MatchScene scene = with_points(rooms_scene(), {});
  scene.scan.free_rays.clear();
  const auto matcher = make();
  EXPECT_FALSE(ask(*matcher, scene.problem(scene.map_from_base, kPrior)).accepted());
  scene.scan.free_rays.push_back({{0.0, 0.0}, {5.0, 0.0}});
  EXPECT_FALSE(ask(*matcher, scene.problem(scene.map_from_base, kPrior)).accepted())
      << "rays without return say nothing";
}

void one_point(const MatcherFactory& make) {
  const auto matcher = make();
  for (const ScanPoint& point : {rooms_scene().scan.points.front(), point_at(0.0, 0.0)}) {
    const MatchScene scene = with_points(rooms_scene(), {point});
    const Pose2 predicted = shifted(scene.map_from_base, {0.05, 0.05, 0.02});
    const MatchResult result = ask(*matcher, scene.problem(predicted, kPrior));
    if (result.accepted()) {  // then it must own that it knows next to nothing
      EXPECT_LE(normalised_error_square(result, scene.map_from_base), 36.0);
    }
  }
}

void points_that_are_no_numbers(const MatcherFactory& make) {
  const auto matcher = make();
  const Pose2 predicted = shifted(rooms_scene().map_from_base, {0.05, -0.05, 0.02});
  for (const double bad : {kNan, kInf, -kInf, 1e30, -1e300}) {
    SCOPED_TRACE("coordinate " + std::to_string(bad));
    const MatchScene all_bad =
        with_points(rooms_scene(), std::vector<ScanPoint>(50, point_at(bad, bad)));
    const MatchResult lost = ask(*matcher, all_bad.problem(predicted, kPrior));
    EXPECT_TRUE(!lost.accepted() || lost.map_from_base == predicted)
        << "moved, although the scan says nothing";
    // Among good points they are ignored, or make the match be rejected.
    std::vector<ScanPoint> points = rooms_scene().scan.points;
    for (std::size_t i = 0; i < points.size(); i += 50) {
      points[i] = point_at(i % 100 == 0 ? bad : 1.0, bad);
    }
    const MatchScene some_bad = with_points(rooms_scene(), std::move(points));
    const MatchResult result = ask(*matcher, some_bad.problem(predicted, kPrior));
    if (result.accepted()) {
      expect_found(result, some_bad.map_from_base, 0.02, 0.01);
    }
  }
}

void normals_and_weights_that_are_no_numbers(const MatcherFactory& make) {
  const auto matcher = make();
  for (const double bad : {kNan, kInf}) {
    std::vector<ScanPoint> points = rooms_scene().scan.points;
    for (std::size_t i = 0; i < points.size(); i += 50) {
      points[i].normal = {bad, bad};
      points[i].weight = bad;
    }
    const MatchScene scene = with_points(rooms_scene(), std::move(points));
    ask(*matcher, scene.problem(scene.map_from_base, kPrior));
  }
}

void a_hundred_thousand_beams(const MatcherFactory& make) {
  LaserOptions laser;
  laser.beams = 100000;
  MatchScene scene = rooms_scene();
  scene.scan = look_around(make_rooms_world(3), laser, scene.map_from_base, 5);
  ASSERT_GE(scene.scan.points.size(), 90000U);
  const auto matcher = make();
  const Pose2 predicted = shifted(scene.map_from_base, {0.08, -0.05, 0.04});
  expect_found(ask(*matcher, scene.problem(predicted, kPrior)), scene.map_from_base, 0.02, 0.01);
}

// --- hostile maps and priors ---

void no_map_yet(const MatcherFactory& make) {
  MatchScene scene = rooms_scene();
  scene.map = SlamMap(MapOptions{}, LikelihoodFieldOptions{});
  scene.key_scans.clear();
  const auto matcher = make();
  const Pose2 predicted = shifted(scene.map_from_base, {0.08, -0.05, 0.04});
  const MatchResult result = ask(*matcher, scene.problem(predicted, kPrior));
  EXPECT_TRUE(same_bits(result.map_from_base, predicted)) << "moved, although there is no map";
}

void prediction_far_from_the_map(const MatcherFactory& make) {
  const auto matcher = make();
  const MatchScene& scene = rooms_scene();
  for (const double far : {1e3, 1e6, 1e12, 1e300}) {
    SCOPED_TRACE(std::to_string(far) + " m away");
    const Pose2 predicted{far, -far, 1.0};
    const MatchResult result = ask(*matcher, scene.problem(predicted, kPrior));
    if (result.accepted()) {
      EXPECT_LE((result.map_from_base.translation() - predicted.translation()).norm(), 1e-9 * far);
    }
  }
}

void prior_of_zero_covariance(const MatcherFactory& make) {
  const auto matcher = make();
  const MatchScene& scene = rooms_scene();
  for (const double off : {0.0, 0.03}) {
    const Pose2 predicted = shifted(scene.map_from_base, {off, 0.0, 0.0});
    const MatchResult result = ask(*matcher, scene.problem(predicted, Eigen::Matrix3d::Zero()));
    const Eigen::Vector3d moved = shift_between(predicted, result.map_from_base);
    EXPECT_LE(moved.norm(), 1e-4) << "moved away from a prediction that is certain";
    EXPECT_LE(result.covariance.norm(), 1e-8) << "less certain than before";
  }
}

/// One coordinate known, the others not; a covariance need not be of full rank.
void prior_of_partial_rank(const MatcherFactory& make) {
  const auto matcher = make();
  const MatchScene& scene = rooms_scene();
  for (int known = 0; known < 3; ++known) {
    Eigen::Matrix3d prior = kPrior;
    prior(known, known) = 0.0;
    Eigen::Vector3d shift(0.06, -0.06, 0.03);
    shift(known) = 0.0;
    const MatchResult result =
        ask(*matcher, scene.problem(shifted(scene.map_from_base, shift), prior));
    ASSERT_TRUE(result.accepted()) << to_string(result.status);
    const Eigen::Vector3d error = shift_between(scene.map_from_base, result.map_from_base);
    EXPECT_LE(std::abs(error(known)), 1e-4);
    if (searches(result)) {
      EXPECT_LE(error.head<2>().norm(), 0.02);
      EXPECT_LE(std::abs(error.z()), 0.01);
    }
  }
}

void prior_that_is_no_prior(const MatcherFactory& make) {
  const auto matcher = make();
  const MatchScene& scene = rooms_scene();
  std::vector<std::pair<Pose2, Eigen::Matrix3d>> priors;
  for (const double bad : {kNan, kInf, -kInf}) {
    priors.emplace_back(Pose2{bad, 0.0, 0.0}, kPrior);
    priors.emplace_back(Pose2{0.0, bad, 0.0}, kPrior);
    priors.emplace_back(Pose2{0.0, 0.0, bad}, kPrior);
    for (int i = 0; i < 3; ++i) {
      for (int j = i; j < 3; ++j) {
        Eigen::Matrix3d covariance = kPrior;
        covariance(i, j) = bad;
        covariance(j, i) = bad;
        priors.emplace_back(scene.map_from_base, covariance);
      }
    }
  }
  priors.emplace_back(scene.map_from_base, Eigen::Matrix3d(-kPrior));
  Eigen::Matrix3d asymmetric = kPrior;
  asymmetric(0, 1) = 0.005;
  priors.emplace_back(scene.map_from_base, asymmetric);
  Eigen::Matrix3d indefinite = kPrior;
  indefinite(0, 1) = 0.02;
  indefinite(1, 0) = 0.02;
  priors.emplace_back(scene.map_from_base, indefinite);
  for (const auto& [pose, covariance] : priors) {
    const MatchResult result = ask(*matcher, scene.problem(pose, covariance));
    EXPECT_EQ(result.status, MatchStatus::kRejectedInvalidPrior) << to_string(result.status) << "\n"
                                                                 << covariance;
  }
}

// --- configuration ---

/// A value of the wrong type for an option that has `value`, and the same as people read it.
ParameterValue wrong_type_for(const ParameterValue& value) {
  if (std::holds_alternative<std::string>(value)) {
    return true;
  }
  return std::string("not_a_value");
}

Parameters parameters_of(const std::vector<OptionDescription>& rows) {
  Parameters parameters;
  for (const OptionDescription& row : rows) {
    parameters.set(row.name, row.value);
  }
  return parameters;
}

bool same_rows(const std::vector<OptionDescription>& a, const std::vector<OptionDescription>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const OptionDescription& x, const OptionDescription& y) {
                      return x.name == y.name && x.value == y.value && x.unit == y.unit &&
                             x.allowed == y.allowed && x.meaning == y.meaning;
                    });
}

void options_describe_themselves(const MatcherFactory& make) {
  const auto matcher = make();
  const std::vector<OptionDescription> rows = matcher->options();
  std::set<std::string> names;
  for (const OptionDescription& row : rows) {
    EXPECT_FALSE(row.name.empty());
    EXPECT_FALSE(row.meaning.empty()) << row.name;
    EXPECT_TRUE(names.insert(row.name).second) << row.name << " is listed twice";
  }
  ASSERT_NO_THROW(matcher->configure({})) << "nothing to set";
  EXPECT_TRUE(same_rows(matcher->options(), rows)) << "without parameters the defaults stay";
  ASSERT_NO_THROW(matcher->configure(parameters_of(rows))) << "its own defaults are refused";
  EXPECT_TRUE(same_rows(matcher->options(), rows));
}

/// Something else of the same type, near the value so that it is probably allowed.
std::vector<ParameterValue> others_near(const ParameterValue& value) {
  if (const auto* flag = std::get_if<bool>(&value)) {
    return {!*flag};
  }
  if (const auto* whole = std::get_if<std::int64_t>(&value)) {
    return {*whole + 1, *whole - 1};
  }
  if (const auto* real = std::get_if<double>(&value)) {
    return {*real * 0.99, *real * 1.01, *real + 0.01};
  }
  return {};
}

void options_say_what_is_in_effect(const MatcherFactory& make) {
  for (const OptionDescription& row : make()->options()) {
    for (const ParameterValue& value : others_near(row.value)) {
      const auto matcher = make();
      Parameters parameters;
      parameters.set(row.name, value);
      try {
        matcher->configure(parameters);
      } catch (const ConfigurationError&) {
        continue;  // next to a limit; the other side will do
      }
      for (const OptionDescription& now : matcher->options()) {
        if (now.name == row.name) {
          EXPECT_EQ(to_string(now.value), to_string(value)) << row.name;
        }
      }
    }
  }
}

void unknown_key_is_refused(const MatcherFactory& make) {
  const auto matcher = make();
  Parameters parameters;
  parameters.set("no_such_option", 1);
  const std::string text = error_text<ConfigurationError>([&] { matcher->configure(parameters); });
  EXPECT_TRUE(contains(text, "no_such_option")) << text;
}

void bad_value_is_refused(const MatcherFactory& make) {
  for (const OptionDescription& row : make()->options()) {
    const auto matcher = make();
    const auto expect_refused = [&](const ParameterValue& value) {
      Parameters parameters;
      parameters.set(row.name, value);
      const std::string text =
          error_text<ConfigurationError>([&] { matcher->configure(parameters); });
      EXPECT_TRUE(contains(text, row.name)) << "names no key: " << text;
      EXPECT_TRUE(contains(text, to_string(value))) << "names no value: " << text;
      EXPECT_TRUE(contains(text, row.allowed)) << "does not say what is allowed: " << text;
    };
    expect_refused(wrong_type_for(row.value));
    if (std::holds_alternative<double>(row.value)) {
      expect_refused(kNan);
    }
  }
}

void failing_to_configure_changes_nothing(const MatcherFactory& make) {
  const auto matcher = make();
  const std::vector<OptionDescription> rows = matcher->options();
  const std::vector<Question> asked = questions();
  const std::vector<MatchResult> before = answers(*matcher, asked);
  Parameters parameters;
  for (const OptionDescription& row : rows) {
    const std::vector<ParameterValue> others = others_near(row.value);
    if (!others.empty()) {
      parameters.set(row.name, others.front());
    }
  }
  parameters.set("no_such_option", 1);
  EXPECT_THROW(matcher->configure(parameters), ConfigurationError);
  EXPECT_TRUE(same_rows(matcher->options(), rows));
  const std::vector<MatchResult> after = answers(*matcher, asked);
  for (std::size_t i = 0; i < before.size(); ++i) {
    EXPECT_TRUE(same_bits(before[i], after[i]));
  }
}

// --- registration ---

using Check = void (*)(const MatcherFactory& make);

class ConformanceTest : public testing::Test {
 public:
  ConformanceTest(MatcherFactory make, Check check) : make_(std::move(make)), check_(check) {}
  void TestBody() override { check_(make_); }

 private:
  MatcherFactory make_;
  Check check_;
};

}  // namespace

void register_matcher_conformance(const std::string& name, const MatcherFactory& make) {
  const std::vector<std::pair<const char*, Check>> checks = {
      {"Identity", identity},
      {"KnownShiftsInRooms", known_shifts_in_rooms},
      {"KnownShiftsInClutter", known_shifts_in_clutter},
      {"KnownShiftsInLoop", known_shifts_in_loop},
      {"KeepsPriorAlongCorridor", keeps_prior_along_corridor},
      {"SameProblemSameBits", same_problem_same_bits},
      {"TwoThreadsAtOnce", two_threads_at_once},
      {"EmptyScan", empty_scan},
      {"OnePoint", one_point},
      {"PointsThatAreNoNumbers", points_that_are_no_numbers},
      {"NormalsAndWeightsThatAreNoNumbers", normals_and_weights_that_are_no_numbers},
      {"AHundredThousandBeams", a_hundred_thousand_beams},
      {"NoMapYet", no_map_yet},
      {"PredictionFarFromTheMap", prediction_far_from_the_map},
      {"PriorOfZeroCovariance", prior_of_zero_covariance},
      {"PriorOfPartialRank", prior_of_partial_rank},
      {"PriorThatIsNoPrior", prior_that_is_no_prior},
      {"OptionsDescribeThemselves", options_describe_themselves},
      {"OptionsSayWhatIsInEffect", options_say_what_is_in_effect},
      {"UnknownKeyIsRefused", unknown_key_is_refused},
      {"BadValueIsRefused", bad_value_is_refused},
      {"FailingToConfigureChangesNothing", failing_to_configure_changes_nothing}};
  for (const auto& [test, check] : checks) {
    testing::RegisterTest(
        name.c_str(), test, nullptr, nullptr, __FILE__, __LINE__,
        [make, check = check]() -> ConformanceTest* { return new ConformanceTest(make, check); });
  }
}

}  // namespace matchbox_slam
