// SPDX-License-Identifier: BSD-3-Clause
#include "solver/time/checkpoint.h"

#include <cstring>

#include "geometry/core/case_files.h"
#include "geometry/core/errors.h"

namespace mv {
namespace {

// Increase when a field is added to State or Checkpoint.
constexpr const char* magic = "mvsolve checkpoint 6\n";
constexpr std::size_t checksum_length = 64;

class Writer {
 public:
  explicit Writer(std::string& out) : out_(out) {}
  template <class T>
  void operator()(T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    out_.append(reinterpret_cast<const char*>(&value), sizeof(T));
  }
  void operator()(std::string& text) { sequence(text); }
  template <class T>
  void operator()(std::vector<T>& values) {
    sequence(values);
  }

 private:
  template <class S>
  void sequence(S& s) {
    std::uint64_t size = s.size();
    (*this)(size);
    out_.append(reinterpret_cast<const char*>(s.data()), size * sizeof(*s.data()));
  }
  std::string& out_;
};

class Reader {
 public:
  Reader(const std::string& in, std::size_t at, std::size_t end, std::string name) : in_(in), at_(at), end_(end), name_(std::move(name)) {}
  template <class T>
  void operator()(T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    take(reinterpret_cast<char*>(&value), sizeof(T));
  }
  void operator()(std::string& text) { sequence(text); }
  template <class T>
  void operator()(std::vector<T>& values) {
    sequence(values);
  }

  bool is_at_end() const { return at_ == end_; }

 private:
  template <class S>
  void sequence(S& s) {
    std::uint64_t size = 0;
    (*this)(size);
    if (size > (end_ - at_) / sizeof(*s.data())) throw InputError(name_ + ": is damaged (a field is longer than the file)");
    s.resize(size);
    take(reinterpret_cast<char*>(s.data()), size * sizeof(*s.data()));
  }
  void take(char* to, std::size_t bytes) {
    if (bytes > end_ - at_) throw InputError(name_ + ": is damaged (ends early)");
    if (bytes > 0) std::memcpy(to, in_.data() + at_, bytes);
    at_ += bytes;
  }
  const std::string& in_;
  std::size_t at_, end_;
  std::string name_;
};

template <class Archive>
void archive_state(Archive& a, State& s) {
  a(s.time), a(s.step), a(s.x), a(s.v);
  for (auto& c : s.flow.velocity.c) a(c);
  a(s.flow.pressure);
  for (auto& c : s.flow.rate_old.c) a(c);
  a(s.flow.dt_old), a(s.flow.boundary_pressure), a(s.holding), a(s.relax_steps), a(s.mean_volume), a(s.relax_shift), a(s.unseen_shift), a(s.unseen_work), a(s.film_gaps), a(s.friction_slip), a(s.ledger);
  a(s.dt), a(s.frequency), a(s.mode_shape), a(s.stiffest_part), a(s.dt_cap), a(s.cap_until_step), a(s.last_estimate), a(s.next_estimate), a(s.energy_at_estimate), a(s.contact_at_estimate), a(s.is_stiffening), a(s.rollbacks), a(s.rollbacks_in_a_row), a(s.fastest), a(s.flow_step);
  a(s.dt_sum), a(s.dt_min), a(s.volume_backward), a(s.volume_swept), a(s.flow_rate), a(s.closure_began), a(s.volume_at_closure_start);
  a(s.closing_volume), a(s.closing_time), a(s.elastic_energy), a(s.chordae_energy), a(s.contact_energy), a(s.initial_energy);
  a(s.controlled_fraction_max), a(s.penetration_max), a(s.J_min), a(s.J_max);
}

template <class Archive>
void archive(Archive& a, Checkpoint& c) {
  archive_state(a, c.state);
  a(c.has_snapshot);
  if (c.has_snapshot) archive_state(a, c.snapshot);
  a(c.next_series), a(c.next_frame), a(c.next_fluid), a(c.next_checkpoint), a(c.leak_volume_before), a(c.leak_time_before), a(c.leak_samples), a(c.peak_velocity), a(c.volume_drift_max), a(c.limiter), a(c.wall_seconds), a(c.case_hash);
}

}  // namespace

void write_checkpoint(const std::filesystem::path& file, const Checkpoint& checkpoint) {
  std::string bytes = magic;
  Writer writer(bytes);
  Checkpoint copy = checkpoint;
  archive(writer, copy);
  bytes += sha256(bytes);
  std::error_code ignored;
  std::filesystem::create_directories(file.parent_path(), ignored);
  write_text_atomically(file, bytes);
}

Checkpoint read_checkpoint(const std::filesystem::path& file) {
  if (!std::filesystem::exists(file)) throw IoError(file.string() + ": no checkpoint to resume from; run without --resume");
  const std::string bytes = read_file(file);
  const std::size_t start = std::strlen(magic);
  if (bytes.size() < start + checksum_length || bytes.compare(0, start, magic) != 0)
    throw InputError(file.string() + ": is not a checkpoint of this version of mvsolve; run without --resume");
  const std::size_t end = bytes.size() - checksum_length;
  if (sha256(bytes.substr(0, end)) != bytes.substr(end)) throw InputError(file.string() + ": is damaged (checksum); run without --resume");
  Checkpoint checkpoint;
  Reader reader(bytes, start, end, file.string());
  archive(reader, checkpoint);
  if (!reader.is_at_end()) throw InputError(file.string() + ": is damaged (longer than its fields); run without --resume");
  return checkpoint;
}

}  // namespace mv
