#include "input/health.h"

#include <utility>

namespace gprodom {

Health::Health(double warning_period_s) : period_(from_seconds(warning_period_s)) {}

void Health::count(const std::string& channel, std::size_t times, const std::string& reason) {
  if (times == 0) return;
  const std::string key = channel + ": " + reason;
  const auto [found, first] = events_.try_emplace(key);
  Event& event = found->second;
  event.count += static_cast<std::int64_t>(times);
  if (!first && now_ < event.last_warning + period_) return;
  const std::int64_t since = event.count - event.at_last_warning;
  warnings_.push_back(since > 1 ? key + " (" + std::to_string(since) + " times)" : key);
  event.at_last_warning = event.count;
  event.last_warning = now_;
}

void Health::set(const std::string& topic, HealthLevel level, const std::string& text) {
  if (text.empty()) {
    const auto it = conditions_.find(topic);
    if (it == conditions_.end()) return;
    if (it->second.warned) warnings_.push_back(topic + ": over: " + it->second.text);
    conditions_.erase(it);
    return;
  }
  Condition& condition = conditions_[topic];
  if (!condition.warned) warnings_.push_back(topic + ": " + text);
  condition = {level, text, true};
}

void Health::await(const std::string& topic, HealthLevel level, const std::string& text) {
  if (text.empty())
    conditions_.erase(topic);
  else
    conditions_[topic] = {level, text, false};
}

Status Health::status(TimeNs now) const {
  Status status;
  status.time = now;
  for (const auto& [topic, condition] : conditions_) {
    status.health = std::max(status.health, condition.level);
    status.reasons.push_back(topic + ": " + condition.text);
  }
  for (const auto& [key, event] : events_) {
    status.names.push_back(key);
    status.values.push_back(static_cast<double>(event.count));
  }
  for (const auto& [name, value] : values_) {
    status.names.push_back(name);
    status.values.push_back(value);
  }
  return status;
}

std::vector<std::string> Health::take_warnings() { return std::exchange(warnings_, {}); }

}  // namespace gprodom
