#include "input/input_check.h"

#include <algorithm>

#include "input/plausibility.h"

namespace gprodom {

namespace {

constexpr char kGap[] = "gap: messages lost or late";
constexpr char kNoData[] = "no data for a second or more";
constexpr char kStaysStuck[] = "values stuck for a second or more";

void shift_stamps(InputMessage& message, TimeNs by) {
  std::visit([by](auto& m) { m.time += by; }, message);
  if (auto* displacement = std::get_if<Displacement>(&message)) {
    displacement->from += by;
    displacement->to += by;
  }
}

struct Channel {
  const std::string& name;
  TimeGuard::Source source;
  double offset_s;
};

double trace_offset_s(const InputMessage& message, const GprConfig& config) {
  const auto* trace = std::get_if<GprTrace>(&message);
  if (!trace) return config.time_offset;
  const auto own = config.time_offsets.find(trace->antenna_id);
  return own == config.time_offsets.end() ? config.time_offset : own->second;
}

Channel channel_of(const InputMessage& message, const Config& config) {
  const ChannelConfig& c = config.channels;
  const Channel channels[] = {{c.imu, TimeGuard::kImu, config.imu.time_offset},
                              {c.wheel, TimeGuard::kWheel, config.wheel.time_offset},
                              {c.wheels, TimeGuard::kWheels, config.wheel.time_offset},
                              {c.gpr_trace, TimeGuard::kGpr, trace_offset_s(message, config.gpr)},
                              {c.displacement_in, TimeGuard::kDisplacement, 0.0},
                              {c.position_fix, TimeGuard::kFix, 0.0}};
  return channels[message.index()];
}

TimeNs time_of(const InputMessage& message) {
  return std::visit([](const auto& m) { return m.time; }, message);
}

}  // namespace

InputCheck::InputCheck(const Config& config, Health& health)
    : config_(config), health_(health), time_guard_(config.time), trigger_(config.gpr.trigger) {
  for (const auto& [id, place] : config.gpr.antennas) antennas_[id];
  if (!antennas_.empty()) antenna_ = antennas_.begin()->first;
}

bool InputCheck::is_other_antenna(const InputMessage& message) const {
  const auto* trace = std::get_if<GprTrace>(&message);
  return trace && antenna_.value_or(trace->antenna_id) != trace->antenna_id;
}

bool InputCheck::accept(InputMessage& message) {
  const std::string reason = refusal(message);
  const TimeNs time = time_of(message);
  const auto* trace = std::get_if<GprTrace>(&message);
  if (const auto* fix = std::get_if<PositionFix>(&message)) note_outage(*fix);
  if (!reason.empty()) {
    health_.count(channel_of(message, config_).name, reason);
    if (reason == kStuck) (trace ? antennas_.at(trace->antenna_id).stuck : imu_stuck_) = time;
    return false;
  }
  health_.advance(time);
  watch(message);
  if (std::holds_alternative<ImuSample>(message)) {
    imu_now_ = std::max(imu_now_, time);
    choose_antenna();
  }
  const auto* wheel = std::get_if<WheelSample>(&message);
  const auto* wheels = std::get_if<WheelsSample>(&message);
  if (wheels) pair_heard_ = true;
  if (wheel || wheels) {
    wheel_m_ = wheel ? wheel->distance_m : 0.5 * (wheels->left_m + wheels->right_m);
    wheel_now_ = std::max(wheel_now_, time);
    trigger_.add_wheel(time, wheel_m_);
  }
  if (trace) {
    antennas_.at(trace->antenna_id).newest = time;
    if (!antenna_) antenna_ = trace->antenna_id;
    if (trace->antenna_id == *antenna_) trigger_.add_trace(time);
  }
  return true;
}

// Values, then the sensor's state, then the stamp. Empty where the message can be used.
std::string InputCheck::refusal(InputMessage& message) {
  const Channel channel = channel_of(message, config_);
  const TimeNs time =
      std::visit([&](auto& m) { return m.time += from_seconds(channel.offset_s); }, message);
  std::string reason = std::visit([&](const auto& m) { return fault(m, config_); }, message);
  if (reason.empty() && pair_heard_ && std::holds_alternative<WheelSample>(message))
    reason = "not used: there are messages of left and right wheels";
  const auto* imu = std::get_if<ImuSample>(&message);
  const auto* trace = std::get_if<GprTrace>(&message);
  if (reason.empty() && imu) reason = imu_watch_.check(*imu);
  if (reason.empty() && trace) reason = refusal(*trace);
  TimeNs usable = time;
  const auto source = is_other_antenna(message) ? TimeGuard::kMoreGpr : channel.source;
  if (reason.empty()) reason = time_guard_.check(source, usable);
  if (!reason.empty()) return reason;
  shift_stamps(message, usable - time);
  return trace && usable <= antennas_.at(trace->antenna_id).newest ? "out of order" : "";
}

// Traces of different antennas cannot be mixed: they look at different places.
std::string InputCheck::refusal(const GprTrace& trace) {
  const bool configured = !config_.gpr.antennas.empty();
  if (!antenna_ && antennas_.count(trace.antenna_id) == 0) {  // it may become the antenna
    antennas_.clear();
    antennas_[trace.antenna_id];
  }
  const auto antenna = antennas_.find(trace.antenna_id);
  if (antenna == antennas_.end())
    return configured ? "antenna_id is not in gpr.antennas"
                      : "of a second antenna: name both in gpr.antennas";
  const std::string reason = antenna->second.format.check(trace);
  return reason.empty() ? antenna->second.quality.check(trace, wheel_m_) : reason;
}

void InputCheck::note_outage(const PositionFix& fix) {
  const bool outage = fix.quality == FixQuality::kNone;
  if (!outage || outage_begin_ == 0) outage_begin_ = outage ? fix.time : 0;
  outage_now_ = fix.time;
}

// Reports weaknesses of a message that is used all the same.
void InputCheck::watch(const InputMessage& message) {
  if (std::holds_alternative<Displacement>(message) || std::holds_alternative<PositionFix>(message))
    return;
  const std::string& name = channel_of(message, config_).name;
  const TimeNs time = time_of(message);
  const auto* trace = std::get_if<GprTrace>(&message);
  Antenna* antenna = trace ? &antennas_.at(trace->antenna_id) : nullptr;
  // Between traces by distance there are pauses.
  const bool pauses = trace && trigger_.trigger() != Trigger::kTime;
  GapWatch& gaps = antenna ? antenna->gaps : gaps_[message.index()];
  if (!pauses && gaps.gap_before(time)) health_.count(name, kGap);
  const bool imu = std::holds_alternative<ImuSample>(message);
  std::string weak = imu ? imu_watch_.quality() : "";
  if (antenna) {
    weak = antenna->quality.quality(*trace);
    if (!antenna->quality.dead()) {
      if (antenna->signal + kSecond < time) antenna->since = time;
      antenna->signal = time;
    }
  }
  if (!weak.empty()) health_.count(name, weak);
  const bool other_antenna = is_other_antenna(message);  // it has the clock of the first
  if (!imu && !other_antenna && clocks_[message.index()].drifts(time, imu_now_))
    health_.count(name, "clock and the IMU's drift apart: 50 ppm or more");
}

const std::string& InputCheck::wheel_channel() const {
  return pair_heard_ ? config_.channels.wheels : config_.channels.wheel;
}

std::optional<TraceFormat> InputCheck::trace_format() const {
  if (!antenna_) return std::nullopt;
  const auto first = antennas_.at(*antenna_).format.agreed();
  return first ? first : antennas_.at(*followed()).format.agreed();
}

bool InputCheck::radar_silent() const {
  return is_silent(antenna_ ? antennas_.at(*followed()).newest : 0);
}

bool InputCheck::is_silent(TimeNs newest_trace) const {
  if (newest_trace + kSecond >= imu_now_) return false;
  const bool wheel_tells = wheel_now_ + kSecond >= imu_now_;
  if (trigger_.trigger() == Trigger::kTime || !wheel_tells || trigger_.is_due()) return true;
  return antenna_ && newest_trace + kSecond < antennas_.at(*antenna_).newest;
}

// With one antenna of several left, the estimate goes on as with one. The first one is waited for,
// since a gap is bridged sooner than another antenna has seen enough; and it must be there for a
// while before it is used again. By traces that come by distance our front ends say nothing
// (RadarTask), so that no other antenna could stand in.
void InputCheck::choose_antenna() {
  constexpr TimeNs kGone = 3 * kSecond, kBack = 2 * kSecond;
  if (config_.gpr.antennas.size() < 2 || trigger_.trigger() != Trigger::kTime) return;
  if (first_imu_ == 0) first_imu_ = imu_now_;
  const auto heard = [this](const Antenna& a) { return a.signal + kSecond >= imu_now_; };
  const Antenna& first = antennas_.at(*antenna_);
  if (heard(first)) {
    if (first.signal - first.since >= kBack) deputy_.reset();
    return;
  }
  if (std::max(first.signal, first_imu_) + kGone >= imu_now_) return;
  if (deputy_ && heard(antennas_.at(*deputy_))) return;
  for (const auto& [id, other] : antennas_)
    if (id != *antenna_ && heard(other)) deputy_ = id;
}

void InputCheck::watch_silence(bool radar_used) {
  const auto watch = [&](const std::string& topic, bool silent, TimeNs stuck) {
    const bool speaks = stuck + kSecond >= imu_now_;
    health_.set(topic, HealthLevel::kDegraded, !silent ? "" : speaks ? kStaysStuck : kNoData);
  };
  health_.set(config_.channels.imu, HealthLevel::kFailed, "");
  watch(wheel_channel(), config_.wheel.enabled && wheel_now_ + kSecond < imu_now_, 0);
  health_.set("one antenna", HealthLevel::kDegraded,
              radar_used && deputy_
                  ? "the first one of gpr.antennas is gone: another one is used in its place"
                  : "");
  const bool outage = outage_begin_ > 0 && outage_begin_ + kSecond <= outage_now_;
  health_.set(config_.channels.position_fix, HealthLevel::kOk,
              outage ? "outage: no position for a second or more" : "");
  if (antennas_.empty()) watch(config_.channels.gpr_trace, radar_used && is_silent(0), 0);
  for (const auto& [id, antenna] : antennas_) {
    const bool followed = id == antenna_;
    const std::string which = followed ? "" : " antenna " + std::to_string(id);
    const bool silent = radar_used && is_silent(antenna.newest);
    watch(config_.channels.gpr_trace + which, silent, antenna.stuck);
    const bool no_signal = radar_used && antenna.signal + kSecond < antenna.newest;
    health_.set("radar" + which, HealthLevel::kDegraded,
                no_signal ? "traces without a signal for a second or more" : "");
  }
}

// Before the first message of the IMU the other stamps may be anything.
std::optional<Status> InputCheck::status_without_clock() {
  const TimeNs time = time_guard_.newest_of_others();
  if (time < imu_now_ + kSecond) return std::nullopt;
  const bool went_back = time + 2 * kSecond < next_lost_status_;
  if (time < next_lost_status_ && !went_back) return std::nullopt;
  const bool first = next_lost_status_ == 0;
  next_lost_status_ = (time / kSecond + 1) * kSecond;
  if (first) return std::nullopt;
  health_.set(config_.channels.imu, HealthLevel::kFailed,
              imu_stuck_ + kSecond >= time ? kStaysStuck : kNoData);
  return health_.status(time);
}

}  // namespace gprodom
