// What holds another thread back until a test lets it go.
#pragma once

#include <future>
#include <utility>

namespace gprodom {

// Whoever waits for it goes on when it is opened.
class Gate {
 public:
  void open() {
    if (!std::exchange(opened_, true)) promise_.set_value();
  }
  void wait() const { open_.wait(); }

 private:
  bool opened_ = false;
  std::promise<void> promise_;
  std::shared_future<void> open_ = promise_.get_future().share();
};

}  // namespace gprodom
