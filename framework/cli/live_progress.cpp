#include "live_progress.hpp"

#include <unistd.h>

#include <chrono>
#include <fstream>
#include <nlohmann/json.hpp>

namespace plumbline::cli {

namespace fs = std::filesystem;

LiveProgress::LiveProgress(const fs::path& folder, size_t total) : file_(folder / file_name), total_(total) {
  std::error_code ignored;
  fs::remove(file_, ignored);  // of a run that was killed
  thread_ = std::thread([this] { write_at_times(); });
}

LiveProgress::~LiveProgress() {
  {
    const std::scoped_lock lock(mutex_);
    ended_ = true;
  }
  end_.notify_all();
  thread_.join();
  std::error_code ignored;
  fs::remove(file_, ignored);
}

void LiveProgress::started(const std::string& node, size_t items) {
  const std::scoped_lock lock(mutex_);
  const double now = std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
  running_[node] = {now, 0, 0, items, ""};
  changed_ = true;
}

void LiveProgress::at(const std::string& node, size_t items_done, size_t items, double fraction,
                      const std::string& text) {
  const std::scoped_lock lock(mutex_);
  const auto found = running_.find(node);
  if (found == running_.end()) return;
  found->second.items_done = items_done, found->second.items = items;
  found->second.fraction = fraction, found->second.text = text;
  changed_ = true;
}

void LiveProgress::finished(const std::string& node) {
  const std::scoped_lock lock(mutex_);
  running_.erase(node);
  ++done_;
  changed_ = true;
}

std::string LiveProgress::text() const {
  nlohmann::ordered_json json{
      {"process", getpid()}, {"done", done_}, {"total", total_}, {"running", nlohmann::ordered_json::array()}};
  for (const auto& [name, node] : running_)
    json["running"].push_back({{"name", name},
                               {"start", node.start},
                               {"items_done", node.items_done},
                               {"items", node.items},
                               {"fraction", node.fraction},
                               {"text", node.text}});
  return json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

/// A thread of its own, because the last thing that happens may be followed by an hour of silence.
void LiveProgress::write_at_times() {
  constexpr auto pause = std::chrono::milliseconds(500);
  const fs::path fresh = file_.string() + ".new";
  std::unique_lock lock(mutex_);
  while (!end_.wait_for(lock, pause, [&] { return ended_; })) {
    if (!changed_) continue;
    changed_ = false;
    const std::string now = text();
    lock.unlock();
    std::ofstream stream(fresh, std::ios::binary);
    stream << now;
    stream.close();
    std::error_code ignored;
    if (stream) fs::rename(fresh, file_, ignored);
    if (!stream || ignored) fs::remove(fresh, ignored);
    lock.lock();
  }
}

}  // namespace plumbline::cli
