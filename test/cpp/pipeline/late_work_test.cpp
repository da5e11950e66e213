// Solver, mapper and radar that are too slow: no pose waits for them, what they are given stays
// bounded, and what is lost is told. No clock of the machine decides: a job that is too slow is one
// that the test lets go when it likes.
#include <ceres/autodiff_cost_function.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <memory>
#include <thread>

#include "gprodom/user_factor.h"
#include "pipeline/pipeline.h"
#include "pipeline/test_drive.h"
#include "support/gate.h"
#include "support/told.h"

namespace gprodom {
namespace {

// No information, and not given before the gate is opened.
struct Held {
  const Gate& gate;
  template <class T>
  bool operator()(const T* p, T* r) const {
    gate.wait();
    r[0] = T(0.0) * p[0];
    return true;
  }
};

class Robot {
 public:
  explicit Robot(Execution execution, const std::vector<std::string>& settings = {},
                 const gpr::FrontEndFactory& front_end = {})
      : pipeline(default_config(settings), execution, front_end, {}) {}

  // Feeds what lies in the time; `then` is called after each message.
  template <class Then>
  void drive(const std::vector<Input>& inputs, TimeNs from, TimeNs to, Then then) {
    for (const Input& input : inputs) {
      const TimeNs time = time_of(input);
      if (time < from || time >= to) continue;
      give(pipeline, input);
      take(pipeline.step());
      pipeline.start_jobs();
      then();
    }
  }
  void drive(const std::vector<Input>& inputs, TimeNs from, TimeNs to) {
    drive(inputs, from, to, [] {});
  }
  // As on a machine that is fast enough: all workers have finished before the next message.
  void drive_in_time(const std::vector<Input>& inputs, TimeNs from, TimeNs to) {
    drive(inputs, from, to, [this] { pipeline.drain(); });
  }
  void take(const Outputs& out) {
    poses.insert(poses.end(), out.odometry.begin(), out.odometry.end());
    corrections.insert(corrections.end(), out.corrections.begin(), out.corrections.end());
    if (!out.status.empty()) status = out.status.back();
  }
  double value(const std::string& name) const { return value_of(status, name).value_or(0.0); }
  // In map: by the correction in force.
  Eigen::Vector3d place() const {
    const Correction& c = corrections.back();
    return c.q_map_odom * poses.back().p_odom_body + c.p_map_odom;
  }

  Pipeline pipeline;
  std::vector<OdometryEstimate> poses;
  std::vector<Correction> corrections;
  Status status;
};

constexpr TimeNs at(double seconds) { return kDriveStart + from_seconds(seconds); }
constexpr double kEnd = 38.0;  // s; after the drive

const char* const kLateSolve = "smoother: solve not ready after smoother.latency: it counts later";
const char* const kLeftOut =
    "smoother: state left out: the solver is slower than smoother.state_rate";
const char* const kLateMap = "map: answer not ready after graph.latency: it counts later";
const char* const kJoined = "map: input joined with later input: the map is slower than the robot";
const char* const kLateTick = "radar: tick not answered within gpr.latency_budget";

TEST(LateWork, WorkersInTimeGiveTheReplayToTheLastBit) {
  const auto inputs = there_and_back(1);
  Robot replay(Execution::kInline), live(Execution::kThreaded);
  replay.drive(inputs, 0, at(kEnd));
  live.drive_in_time(inputs, 0, at(kEnd));
  EXPECT_TRUE(same_poses(live.poses, replay.poses));
  ASSERT_GT(replay.corrections.size(), 5U);
  ASSERT_EQ(live.corrections.size(), replay.corrections.size());
  for (std::size_t i = 0; i < live.corrections.size(); ++i)
    ASSERT_EQ(live.corrections[i].p_map_odom, replay.corrections[i].p_map_odom);
  EXPECT_EQ(live.status.names, replay.status.names);
  EXPECT_EQ(live.status.values, replay.status.values);
}

// The mapper takes five seconds for one job, on the way back, when it has revisits to tell. Solver
// and radar answer in time.
TEST(LateWork, MapperThatIsTooSlowChangesNoPoseInOdomAndItsCorrectionComesLater) {
  const auto inputs = there_and_back(1);
  Robot replay(Execution::kInline), live(Execution::kThreaded);
  replay.drive(inputs, 0, at(30.0));
  live.drive_in_time(inputs, 0, at(30.0));
  const std::size_t corrections = live.corrections.size();
  Gate gate;
  live.pipeline.map().save_ground(live.pipeline.now(), false,
                                  [&gate](const SavedGround&) { gate.wait(); });
  for (const Input& input : inputs) {
    const TimeNs time = time_of(input);
    if (time < at(30.0) || time >= at(35.0)) continue;
    replay.drive({input}, time, time + 1);
    const Timing done = replay.pipeline.timing();
    live.drive({input}, time, time + 1, [&] {
      const auto is_late = [&](const Timing& t) {
        return t.solver.ready.count() < done.solver.jobs || t.radar.ready.count() < done.radar.jobs;
      };
      while (is_late(live.pipeline.timing())) std::this_thread::yield();
    });
  }
  EXPECT_LE(live.corrections.size(), corrections + 1) << "one was ready";
  ASSERT_GT(replay.corrections.size(), corrections + 5);
  gate.open();
  replay.drive(inputs, at(35.0), at(kEnd));
  live.drive_in_time(inputs, at(35.0), at(kEnd));
  EXPECT_TRUE(same_poses(live.poses, replay.poses));
  EXPECT_GE(live.value(kLateMap), 1.0);
  EXPECT_GE(live.value(kJoined), 6.0) << "jobs of half a second each wait";
  EXPECT_EQ(live.value("map: trace or revisit dropped: the map is slower than the robot"), 0.0);
  ASSERT_GT(live.corrections.size(), corrections + 1);
  const Eigen::Vector3d apart = live.place() - replay.place();
  const double sigma = std::sqrt(replay.corrections.back().covariance(0, 0));
  EXPECT_LT(std::abs(apart.x()), 3 * sigma);
  EXPECT_NEAR(live.corrections.back().revisits, replay.corrections.back().revisits,
              0.2 * replay.corrections.back().revisits);
}

// The solver takes ten seconds for one state.
TEST(LateWork, SolverThatIsTooSlowHoldsUpNoPoseAndItsStatesAreBounded) {
  const auto inputs = there_and_back(1);
  const std::vector<std::string> alone = {"gpr.enabled=false"};
  Robot replay(Execution::kInline, alone), live(Execution::kThreaded, alone);
  replay.drive(inputs, 0, at(kEnd));
  Gate gate;
  live.drive_in_time(inputs, 0, at(10.0));
  const UserFactor held{"held",
                        {at(9.9)},
                        {{0, StatePart::kPosition}},
                        std::make_shared<ceres::AutoDiffCostFunction<Held, 1, 3>>(new Held{gate}),
                        nullptr};
  ASSERT_EQ(live.pipeline.add_factor(held), "");
  const std::size_t poses = live.poses.size();
  live.drive(inputs, at(10.0), at(20.0));
  EXPECT_EQ(live.poses.size(), poses + 1000);
  const auto jobs = live.pipeline.timing().solver.jobs;
  EXPECT_GE(live.value(kLateSolve), 1.0);
  EXPECT_GE(live.value(kLeftOut), 30.0) << "those of a second may wait, then one each second";
  gate.open();
  live.drive_in_time(inputs, at(20.0), at(kEnd));
  EXPECT_LE(live.pipeline.timing().solver.jobs, jobs + 1 + 5 + 10 + 18 * 5);
  ASSERT_EQ(live.poses.size(), replay.poses.size());
  EXPECT_TRUE(std::all_of(live.poses.begin(), live.poses.end(),
                          [](const auto& pose) { return pose.p_odom_body.allFinite(); }));
  const double apart = (live.poses.back().p_odom_body - replay.poses.back().p_odom_body).norm();
  const double sigma = std::sqrt(replay.poses.back().pose_covariance.topLeftCorner<2, 2>().trace());
  EXPECT_LT(apart, 3 * sigma);
}

// A tick that takes a hundred seconds. What waits behind it is not run when it is over.
TEST(LateWork, RadarThatIsTooSlowRunsNoTickThatIsOver) {
  Gate gate;
  std::atomic<int> ticks{0};
  // Answers its first tick when the gate is opened, and the others at once.
  const auto held = saying([&](TimeNs) {
    ++ticks;
    gate.wait();
    return std::vector<gpr::Finding>();
  });
  Robot live(Execution::kThreaded, {}, held);
  live.drive(standing(100.0), 0, at(100.0));
  EXPECT_GE(live.value(kLateTick), 985.0);
  EXPECT_LE(ticks, 1);
  gate.open();
  live.pipeline.drain();
  EXPECT_LE(ticks, 2) << "the one that was held, and the newest";
}

}  // namespace
}  // namespace gprodom
