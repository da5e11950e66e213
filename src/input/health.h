// Counts what goes wrong, gives a warning of each kind once per period, and fills status_t.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "gprodom/types.h"

namespace gprodom {

class Health {
 public:
  explicit Health(double warning_period_s);

  // Advances the data time (of any sensor), which limits the rate of warnings.
  void advance(TimeNs now) { now_ = std::max(now_, now); }

  // Counts an event, such as ("IMU", "stamp repeated"). Adds a warning, unless one of the same kind
  // was given within the period.
  void count(const std::string& channel, const std::string& reason) { count(channel, 1, reason); }
  // The same of an event that has happened so many times.
  void count(const std::string& channel, std::size_t times, const std::string& reason);

  // Sets a condition, which stays in the status until it is set with an empty text. Its begin and
  // its end give a warning each.
  void set(const std::string& topic, HealthLevel level, const std::string& text);

  // A condition that is normal for now, such as waiting for the start: in the status, but without a
  // warning until it is set(). An empty text ends it.
  void await(const std::string& topic, HealthLevel level, const std::string& text);

  void value(const std::string& name, double value) { values_[name] = value; }
  void add(const std::string& name, double amount) { values_[name] += amount; }
  void maximum(const std::string& name, double value) {
    values_[name] = std::max(values_[name], value);
  }

  Status status(TimeNs now) const;
  std::vector<std::string> take_warnings();

 private:
  struct Event {
    std::int64_t count = 0, at_last_warning = 0;
    TimeNs last_warning = 0;
  };
  struct Condition {
    HealthLevel level;
    std::string text;
    bool warned = false;
  };

  TimeNs period_, now_ = 0;
  std::map<std::string, Event> events_;  // by "channel: reason"
  std::map<std::string, Condition> conditions_;
  std::map<std::string, double> values_;
  std::vector<std::string> warnings_;
};

}  // namespace gprodom
