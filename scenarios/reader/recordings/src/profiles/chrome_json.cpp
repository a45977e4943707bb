// Trace events of Chrome, Perfetto's legacy export and PyTorch's profiler, as JSON: an array of events, or an object with
// one in "traceEvents". Complete events (X) have a length; begins and ends (B, E) nest in a thread. Times are microseconds,
// with fractions; displayTimeUnit is about the viewer and changes nothing. The file is read as a stream.
#include <fmt/format.h>

#include <map>
#include <nlohmann/json.hpp>

#include "decimal_time.h"
#include "profile_formats.h"

namespace evenstep::internal {
namespace {

constexpr std::int64_t kMicrosecond = 1000;
constexpr int kDeepest = 200;
constexpr std::size_t kLongestToken = std::size_t{16} << 20;
constexpr std::size_t kMostOpen = 1'000'000;  // begins without an end

/// The characters of a stream as iterators of the JSON reader. The stream ends early after a token of kLongestToken bytes,
/// so that the reader need not keep more.
class Characters {
 public:
  explicit Characters(Bytes& bytes) : bytes_(bytes) { refill(); }
  bool done() const { return piece_.empty(); }
  char current() const { return piece_.front(); }
  void advance() {
    piece_.remove_prefix(1);
    if (++since_token_ > kLongestToken) {
      too_long_ = true;
      piece_ = {};
    } else if (piece_.empty()) {
      refill();
    }
  }
  void token_ends() { since_token_ = 0; }
  bool too_long() const { return too_long_; }

 private:
  void refill() { piece_ = bytes_.next(); }
  Bytes& bytes_;
  std::string_view piece_;
  std::size_t since_token_ = 0;
  bool too_long_ = false;
};

class CharacterIterator {
 public:
  using iterator_category = std::input_iterator_tag;
  using value_type = char;
  using difference_type = std::ptrdiff_t;
  using pointer = const char*;
  using reference = char;

  CharacterIterator() = default;  ///< the end
  explicit CharacterIterator(Characters& characters) : characters_(&characters) {}
  char operator*() const { return characters_->current(); }
  CharacterIterator& operator++() {
    characters_->advance();
    return *this;
  }
  CharacterIterator operator++(int) {
    characters_->advance();
    return *this;
  }
  bool operator==(const CharacterIterator& other) const { return at_end() == other.at_end(); }

 private:
  bool at_end() const { return characters_ == nullptr || characters_->done(); }
  Characters* characters_ = nullptr;
};

/// One event, as far as it is known.
struct Event {
  std::string phase, name, category, process, thread, process_name;
  std::optional<std::int64_t> at_ns, length_ns;
  bool too_far = false;
};

/// What nlohmann's reader calls.
class EventReader : public nlohmann::json_sax<nlohmann::json> {
 public:
  EventReader(Characters& characters, ProfileBuilder& builder) : characters_(characters), builder_(builder) {}

  bool null() override { return value(); }
  bool boolean(bool) override { return value(); }
  bool number_integer(number_integer_t number) override { return number_text(std::to_string(number)); }
  bool number_unsigned(number_unsigned_t number) override { return number_text(std::to_string(number)); }
  bool number_float(number_float_t, const string_t& text) override { return number_text(text); }
  bool string(string_t& text) override { return take(text), value(); }
  bool binary(binary_t&) override { return value(); }

  bool start_object(std::size_t) override {
    if (++depth_ > kDeepest) return too_deep();
    if (in_events_ && depth_ == events_depth_ + 1) event_ = {};
    if (in_event() && depth_ == events_depth_ + 2) in_args_ = key_ == "args";
    return value();
  }
  bool end_object() override {
    if (in_event() && depth_ == events_depth_ + 1) add_event();
    if (in_event() && depth_ == events_depth_ + 2) in_args_ = false;
    --depth_;
    return value();
  }
  bool start_array(std::size_t) override {
    if (++depth_ > kDeepest) return too_deep();
    if (depth_ == 1 || (depth_ == 2 && key_ == "traceEvents" && !in_events_)) {
      in_events_ = true;
      events_depth_ = depth_;
    }
    return value();
  }
  bool end_array() override {
    if (in_events_ && depth_ == events_depth_) in_events_ = false, found_events_ = true;
    --depth_;
    return value();
  }
  bool key(string_t& text) override {
    key_.assign(text, 0, std::min<std::size_t>(text.size(), 64));
    return value();
  }
  bool parse_error(std::size_t position, const std::string& last, const nlohmann::detail::exception& error) override {
    if (depth_ == 0 && found_events_ && (last.ends_with('{') || last.ends_with('['))) {
      another_ = true;
    } else if (characters_.done() && in_events_ && depth_ <= events_depth_ + 1 && !characters_.too_long()) {
      // A program that crashed leaves a list without its end; what is before is whole.
      found_events_ = true;
      builder_.leave_out("ends of the file, which is cut off", event_.name);
    } else if (!builder_.failed() && !characters_.too_long()) {
      const std::string message = error.what();  // "[json.exception.parse_error.101] parse error at line …: …"
      const std::size_t after_code = message.find("] ");
      builder_.fail(fmt::format("is no JSON at byte {}: {}", position,
                                after_code == std::string::npos ? message : message.substr(after_code + 2)));
    }
    return false;
  }

  void finish() {
    if (characters_.too_long()) builder_.fail(fmt::format("a text in it is longer than {} bytes", kLongestToken));
    if (builder_.failed()) return;
    if (!found_events_) builder_.fail("is JSON without \"traceEvents\"");
    if (another_) leave_out_another();
    for (const Thread& thread : threads_) {
      for (const Open& begin : thread.open) leave_out_begin(begin);
    }
    for (std::string& source : builder_.profile().sources) {
      const auto named = process_names_.find(source);
      if (named != process_names_.end()) source += " " + named->second;
    }
  }

 private:
  struct Open {
    std::uint32_t name;
    std::int64_t at_ns;
  };
  /// Begins and ends of a thread come in order of time.
  struct Thread {
    std::vector<Open> open;
    std::int64_t last_ns = INT64_MIN;
  };

  bool in_event() const { return in_events_ && depth_ > events_depth_; }
  bool value() {
    characters_.token_ends();
    return !builder_.failed();
  }
  bool too_deep() {
    builder_.fail(fmt::format("is nested more than {} deep", kDeepest));
    return false;
  }
  bool number_text(const std::string& text) { return take(text), value(); }

  /// Keeps a value of the event's own, not of what is nested in it.
  void take(const std::string& text) {
    if (!in_event()) return;
    if (depth_ == events_depth_ + 2 && in_args_ && key_ == "name") event_.process_name = text.substr(0, kLongestName);
    if (depth_ != events_depth_ + 1) return;
    if (key_ == "ph") event_.phase = text.substr(0, 4);
    if (key_ == "name") event_.name = text.substr(0, kLongestName);
    if (key_ == "cat") event_.category = text.substr(0, 100);
    if (key_ == "pid") event_.process = text.substr(0, 100);
    if (key_ == "tid") event_.thread = text.substr(0, 100);
    if (key_ == "ts") event_.at_ns = decimal_time_ns(text, kMicrosecond);
    if (key_ == "dur") event_.length_ns = decimal_time_ns(text, kMicrosecond);
  }

  void add_event();
  void begin_or_end(std::uint32_t track);
  void end_event(std::uint32_t track, Thread& thread);
  void leave_out_another();
  void leave_out_begin(const Open& begin) {
    builder_.leave_out("begins without an end", builder_.profile().names[begin.name].text);
  }

  Characters& characters_;
  ProfileBuilder& builder_;
  int depth_ = 0, events_depth_ = 0;
  bool in_events_ = false, in_args_ = false, found_events_ = false;
  bool another_ = false;  ///< recording behind the first one, whose clock may be another one, too
  std::string key_;
  Event event_;
  std::vector<Thread> threads_;  ///< by track
  std::map<std::string, std::string, std::less<>> process_names_;
  std::size_t open_count_ = 0;
};

/// What categories are called here: those of GPUs are the same for all readers. PyTorch wrote "Kernel" and "Memcpy" up to
/// 1.11, Intel's unitrace writes "gpu_op".
std::string_view category_of(std::string_view category) {
  if (category == "gpu_memcpy" || category == "gpu_memset" || category == "Memcpy" || category == "Memset") return "copy";
  if (category == "gpu_op" || category == "Kernel") return "kernel";
  return category;
}

void EventReader::add_event() {
  if (event_.phase == "M" && event_.name == "process_name" && process_names_.size() < 1000)
    process_names_["process " + event_.process] = event_.process_name.substr(0, 100);
  if (event_.phase != "X" && event_.phase != "B" && event_.phase != "E") return;  // instants, counters, flows: no intervals
  if (!event_.at_ns || *event_.at_ns < -kFurthestTime_ns) return builder_.leave_out("events without a time", event_.name);
  const std::string_view category = category_of(event_.category);
  // A GPU's queue has notes on its track, too, which hold several kernels.
  const bool of_queue = event_.phase == "X" && (category == "kernel" || category == "copy");
  const std::uint32_t track = builder_.track("process " + event_.process, (of_queue ? "queue " : "thread ") + event_.thread,
                                             of_queue ? TrackOrder::follow : TrackOrder::nest);
  if (event_.phase != "X") return begin_or_end(track);
  if (!event_.length_ns || *event_.length_ns > kFurthestTime_ns - std::max<std::int64_t>(*event_.at_ns, 0))
    return builder_.leave_out("complete events without a length", event_.name);
  builder_.add(builder_.name(event_.name, category), track, *event_.at_ns, *event_.at_ns + *event_.length_ns);
}

void EventReader::begin_or_end(std::uint32_t track) {
  if (track >= threads_.size()) threads_.resize(track + 1);
  Thread& thread = threads_[track];
  if (*event_.at_ns < thread.last_ns) return builder_.leave_out("begins and ends whose time goes back", event_.name);
  thread.last_ns = *event_.at_ns;
  if (event_.phase == "E") return end_event(track, thread);
  if (++open_count_ > kMostOpen) return builder_.fail(fmt::format("more than {} begins without an end", kMostOpen));
  thread.open.push_back({builder_.name(event_.name, category_of(event_.category)), *event_.at_ns});
}

/// An end belongs to the last begin of its thread that has its name. It need not have one.
void EventReader::end_event(std::uint32_t track, Thread& thread) {
  constexpr std::size_t kMostSearched = 1000;
  std::vector<Open>& open = thread.open;
  const std::string end = ProfileBuilder::shown(event_.name);
  std::size_t inner = 0;  // begins after the one that ends
  const std::size_t searched = std::min(open.size(), kMostSearched);
  while (inner < searched && !end.empty() && builder_.profile().names[open[open.size() - 1 - inner].name].text != end)
    ++inner;
  if (inner == searched) return builder_.leave_out("ends without a begin", event_.name);
  for (std::size_t i = open.size() - inner; i < open.size(); ++i) leave_out_begin(open[i]);
  const Open begin = open[open.size() - 1 - inner];
  open.resize(open.size() - 1 - inner);
  open_count_ -= inner + 1;
  builder_.add(begin.name, track, begin.at_ns, *event_.at_ns);
}

/// Counts its events by their key "ph".
void EventReader::leave_out_another() {
  std::string last;
  std::int64_t events = 0;
  for (; !characters_.done(); characters_.advance()) {
    characters_.token_ends();
    last += characters_.current();
    if (last.size() > 4) last.erase(0, 1);
    events += last == "\"ph\"";
  }
  builder_.leave_out("events of another recording behind the first one", "", false, std::max<std::int64_t>(events, 1));
}

}  // namespace

bool is_chrome_json(const ProfileInput& input) {
  const std::size_t first = input.first.find_first_not_of(" \t\r\n\xEF\xBB\xBF");
  return first != std::string_view::npos && (input.first[first] == '{' || input.first[first] == '[');
}

void read_chrome_json(ProfileInput& input, const ProfileOptions&, ProfileBuilder& builder) {
  builder.profile().format = "trace events (JSON)";
  builder.profile().time_base = "us, as trace events have them";
  Characters characters(input.bytes);
  EventReader reader(characters, builder);
  (void)nlohmann::json::sax_parse(CharacterIterator(characters), CharacterIterator(), &reader);
  reader.finish();
}

}  // namespace evenstep::internal
