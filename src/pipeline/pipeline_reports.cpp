// What the estimator knows of place, wheels, radar and slip, as STATUS tells it.
#include <cmath>
#include <string>

#include "map/search_window.h"
#include "pipeline/pipeline.h"

namespace gprodom {

// Whether the track is tied to earlier ground, and how surely.
void Pipeline::report_place(const MapAnswer& answer) {
  if (!has_earlier_ground_) return;
  const bool lost = located_ && answer.sigma_m > kLostSigma;
  health_.value("map.located", located_ && !lost ? 1.0 : 0.0);
  health_.value("map.searched_m", located_ ? 0.0 : answer.travelled_m);
  if (located_) health_.value("map.sigma_m", answer.sigma_m);
  if (lost)
    health_.set(
        "map", HealthLevel::kDegraded,
        "lost: no known ground for so long that the position is less certain than the range "
        "of the search");
  else if (located_)
    health_.set("map", HealthLevel::kOk, "");
  else
    health_.await("map", HealthLevel::kOk, "searching for earlier ground");
}

// One whose specific force was not gravity.
void Pipeline::report_accelerometer() {
  const auto percent = static_cast<int>(std::lround(100 * imu_mounting_.accel_scale()));
  health_.set("accelerometer", HealthLevel::kDegraded,
              imu_mounting_.accel_scale() == 1.0
                  ? ""
                  : "its specific force is " + std::to_string(percent) +
                        " % of gravity: taken as its scale and divided out; check its units or its "
                        "range setting");
}

void Pipeline::report_fixes(const FixReport& fixes) {
  health_.value("fixes.used", static_cast<double>(fixes.used));
  health_.value("fixes.refused", static_cast<double>(fixes.refused));
  if (fixes.scale_sigma > 0.0) {
    health_.value("fixes.wheel_scale", fixes.scale);
    health_.value("fixes.wheel_scale_sigma", fixes.scale_sigma);
  }
  if (fixes.datum) {
    health_.value("site.latitude", fixes.datum->x());
    health_.value("site.longitude", fixes.datum->y());
    health_.value("site.height", fixes.datum->z());
  }
  const FixTrouble trouble = fixes.trouble;
  health_.set(
      "fixes", HealthLevel::kDegraded,
      trouble == FixTrouble::kJump
          ? "jump: they contradict the odometry and the fixes before; not used"
      : trouble == FixTrouble::kDrag ? "drag: they move away from where the odometry is; not used"
      : trouble == FixTrouble::kConverged
          ? "after an outage the first ones were off; they are taken back"
      : trouble == FixTrouble::kRepeated
          ? "positions come again that came already: the receiver, or a log, repeats them"
      : trouble == FixTrouble::kSwapped ? "latitude and longitude are swapped"
      : trouble == FixTrouble::kFar     ? "more than 200 km from the datum: is anchor.datum right?"
                                        : "");
}

void Pipeline::report_pair() {
  if (!motion_.pair().received()) return;
  const TurnCalibration& found = motion_.pair().calibration();
  health_.value("wheels.track_m", found.track_m());
  health_.value("wheels.track_sigma_m", found.track_sigma_m());
  health_.value("wheels.radii_difference", found.radii_difference());
  health_.value("wheels.difference_noise", found.noise());
}

// Nothing where the configuration says that traces come by time.
void Pipeline::report_trigger() {
  if (config_.gpr.trigger == Trigger::kTime || !radar_.enabled()) return;
  const Trigger trigger = input_.trigger();
  if (trigger != Trigger::kAuto)
    health_.value("radar.by_distance", trigger == Trigger::kDistance ? 1.0 : 0.0);
  health_.await("radar trigger", HealthLevel::kOk,
                trigger == Trigger::kDistance
                    ? "traces come by distance: their likeness tells no standstill and no slip"
                : trigger == Trigger::kAuto
                    ? "not known before a standstill: until then only ground seen before is used"
                    : "");
}

void Pipeline::report_sight() {
  const auto unseen = motion_.unseen_speed();
  if (!unseen) return;
  health_.value("standstill.unseen_mps", *unseen);
  if (*unseen <= MotionJudge::kUnseenAtFirst || sight_warned_) return;
  sight_warned_ = true;
  health_.count(config_.channels.gpr_trace,
                "the radar cannot detect slow motion on this ground (coarse, smooth or weak): the "
                "wheel decides what is a standstill");
}

// Reports a robot that is stuck, and slip that no sensor would show.
void Pipeline::report_slip() {
  const Immobilised stands = motion_.immobilised();
  health_.set("robot", HealthLevel::kDegraded,
              stands == Immobilised::kYes
                  ? "immobilised: the wheels turn, and the ground under the antenna stands"
                  : "");
  health_.await("standstill", HealthLevel::kOk,
                stands == Immobilised::kCannotTell
                    ? "cannot be told from slow motion: the ground has no texture here"
                    : "");
  const bool unwitnessed = slip_drift_.unwitnessed() && !motion_.wheel_compared();
  const auto centimetres = static_cast<int>(std::lround(100 * slip_drift_.sigma()));
  health_.await("wheel", HealthLevel::kOk,
                unwitnessed ? "unwitnessed: neither the IMU nor the radar would show gradual slip; "
                              "standard deviation per metre " +
                                  std::to_string(centimetres) + " cm"
                            : "");
}

}  // namespace gprodom
