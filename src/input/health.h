// What went wrong and how often, said once per period and summed up for status_t.
#pragma once

#include <algorithm>
#include <map>
#include <string>
#include <vector>

#include "gprodom/types.h"

namespace gprodom {

class Health {
 public:
  explicit Health(double warning_period_s);

  // Data time goes on. It counts for how often one warning is given, so it may be of any sensor.
  void advance(TimeNs now) { now_ = std::max(now_, now); }

  // Counts an event, such as ("IMU", "stamp repeated"), and keeps a warning if none of its kind was
  // given within the period of data time.
  void count(const std::string& channel, const std::string& reason);

  // States for as long as they hold; an empty text ends one. Their begin and end are warned of,
  // the end with what is over.
  void set(const std::string& topic, HealthLevel level, const std::string& text);

  // A state that is as it should be for now: told in the status, not warned of, until it is set().
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
