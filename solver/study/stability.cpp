// SPDX-License-Identifier: BSD-3-Clause
#include "solver/study/stability.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ostream.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#ifdef __linux__
#include <sys/prctl.h>
#endif

#include <algorithm>
#include <chrono>
#include <cstring>
#include <iostream>
#include <map>
#include <mutex>
#include <thread>

#include "geometry/core/case_files.h"
#include "geometry/core/errors.h"
#include "geometry/core/log.h"
#include "geometry/core/parallel.h"
#include "solver/study/case_maker.h"
#include "solver/study/stability_page.h"
#include "solver/study/stability_run.h"

namespace mv {

namespace fs = std::filesystem;

namespace {

using Clock = std::chrono::steady_clock;
double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

// A case that does not stop by itself is ended after this many times its processor time on the clock, and a bit.
constexpr double clock_factor = 4, grace_seconds = 5;
constexpr auto poll_every = std::chrono::milliseconds(20);

void make_directory(const fs::path& directory) {
  std::error_code code;
  fs::create_directories(directory, code);
  if (code) throw IoError(fmt::format("{}: cannot be created: {}", directory.string(), code.message()));
}

std::string geometry_name(const StabilityCase& c) { return "geometry-" + sha256(geometry_toml(c)).substr(0, 10); }

/// Every distinct geometry, `jobs` at a time; by name.
std::map<std::string, MadeCase> make_geometries(const std::vector<StabilityCase>& cases, const StabilityOptions& options) {
  std::map<std::string, std::string> tomls;
  for (const StabilityCase& c : cases) tomls[geometry_name(c)] = geometry_toml(c);
  std::map<std::string, MadeCase> made;
  std::vector<std::pair<std::string, std::string>> todo(tomls.begin(), tomls.end());
  const fs::path mvprep = find_mvprep(options.mvprep);
  std::mutex lock;
  std::size_t next = 0;
  std::exception_ptr failure;
  auto work = [&] {
    while (true) {
      std::size_t i;
      {
        const std::lock_guard guard(lock);
        if (next >= todo.size() || failure || (options.is_interrupted && *options.is_interrupted)) return;
        i = next++;
      }
      try {
        MadeCase m = CaseMaker(options.output, mvprep).make(todo[i].first, todo[i].second);
        const std::lock_guard guard(lock);
        made[todo[i].first] = std::move(m);
      } catch (...) {
        const std::lock_guard guard(lock);
        failure = std::current_exception();
      }
    }
  };
  std::vector<std::thread> threads;
  for (int t = 0; t < options.jobs; ++t) threads.emplace_back(work);
  for (std::thread& t : threads) t.join();
  if (failure) std::rethrow_exception(failure);
  return made;
}

struct Files {
  fs::path outcome, log;
};

Files files_of(const StabilityCase& c, const fs::path& output) { return {output / "outcomes" / (c.name + ".json"), output / "logs" / (c.name + ".log")}; }

/// In the child: runs the case, leaves its outcome in a file. Never returns.
[[noreturn]] void run_child(const StabilityCase& c, const fs::path& case_directory, const Files& files, double seconds) {
#ifdef __linux__
  prctl(PR_SET_PDEATHSIG, SIGKILL);
#endif
  signal(SIGINT, SIG_DFL);
  signal(SIGTERM, SIG_DFL);
  const rlimit no_core{0, 0};
  setrlimit(RLIMIT_CORE, &no_core);
  dup2(open(files.log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0666), STDERR_FILENO);
  dup2(open("/dev/null", O_WRONLY), STDOUT_FILENO);
  int code = 0;
  try {
    write_json(files.outcome, to_json(run_stability_case(c, case_directory, seconds)));
  } catch (const std::exception& error) {
    spdlog::error("{}", error.what());
    code = static_cast<int>(ExitCode::bug);
  }
  _exit(code);
}

std::string last_line(const fs::path& file) {
  const std::string text = fs::exists(file) ? read_file(file) : "";
  const std::size_t end = text.find_last_not_of('\n');
  if (end == std::string::npos) return "";
  const std::size_t before = text.rfind('\n', end);
  return text.substr(before == std::string::npos ? 0 : before + 1, end - (before == std::string::npos ? 0 : before + 1) + 1);
}

struct Running {
  std::size_t row;
  pid_t child;
  Clock::time_point start;
  bool is_ended = false;   // by us, because it did not answer
};

CaseOutcome outcome_of(const StabilityRow& row, const Running& running, int status, const Files& files) {
  CaseOutcome o;
  o.seconds = seconds_since(running.start);
  if (running.is_ended) {
    o.end = CaseEnd::hung;
    o.reason = fmt::format("did not answer for {:.0f} s and was ended", o.seconds);
  } else if (WIFSIGNALED(status)) {
    o.end = CaseEnd::crashed;
    o.reason = fmt::format("signal {} ({})", WTERMSIG(status), strsignal(WTERMSIG(status)));
  } else if (WEXITSTATUS(status) != 0) {
    o.end = CaseEnd::crashed;
    o.reason = last_line(files.log);
  } else {
    o = outcome_from_json(read_json(files.outcome));
  }
  (void)row;
  return o;
}

void print_row(const StabilityRow& row) {
  std::cout << fmt::format("{:<10} {:<34} {:6.1f} s  {}", name_of(row.judgement.verdict), row.stability_case.name, row.outcome.seconds, row.judgement.reason) << std::endl;
}

/// The rows by expected cost, dearest first, so that the last one to end is short.
std::vector<std::size_t> order_of(const std::vector<StabilityRow>& rows) {
  std::vector<std::size_t> order(rows.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return rows[a].stability_case.end > rows[b].stability_case.end; });
  return order;
}

void run_children(std::vector<StabilityRow>& rows, const std::map<std::string, MadeCase>& geometries, const StabilityOptions& options) {
  std::vector<std::size_t> waiting = order_of(rows);
  std::vector<Running> running;
  auto finish = [&](std::size_t i, CaseOutcome outcome) {
    rows[i].outcome = std::move(outcome);
    rows[i].judgement = judge(rows[i].stability_case, rows[i].outcome);
    print_row(rows[i]);
  };
  std::size_t next = 0;
  while (next < waiting.size() || !running.empty()) {
    if (options.is_interrupted && *options.is_interrupted) {
      for (const Running& r : running) {
        kill(r.child, SIGKILL);
        waitpid(r.child, nullptr, 0);
      }
      return;
    }
    while (next < waiting.size() && static_cast<int>(running.size()) < options.jobs) {
      const std::size_t i = waiting[next++];
      const StabilityCase& c = rows[i].stability_case;
      const MadeCase& made = geometries.at(geometry_name(c));
      if (!made.is_made()) {
        CaseOutcome o;
        // A gate or a setting is a refusal; anything else is mvprep's failure.
        const bool is_refusal = made.exit_code >= static_cast<int>(ExitCode::config) && made.exit_code <= static_cast<int>(ExitCode::geometry_gate);
        o.end = is_refusal ? CaseEnd::refused : CaseEnd::crashed;
        o.reason = "mvprep: " + made.error;
        finish(i, o);
        continue;
      }
      const Files files = files_of(c, options.output);
      fs::remove(files.outcome);
      std::cout.flush();
      const pid_t child = fork();
      if (child < 0) throw IoError(fmt::format("a process for case {} cannot be started: {}", c.name, std::strerror(errno)));
      if (child == 0) run_child(c, made.directory, files, options.case_seconds);
      running.push_back({i, child, Clock::now()});
    }
    for (std::size_t r = 0; r < running.size();) {
      int status = 0;
      if (waitpid(running[r].child, &status, WNOHANG) == 0) {
        if (!running[r].is_ended && seconds_since(running[r].start) > clock_factor * options.case_seconds + grace_seconds) {
          kill(running[r].child, SIGKILL);
          running[r].is_ended = true;
        }
        ++r;
        continue;
      }
      const Running done = running[r];
      running.erase(running.begin() + static_cast<std::ptrdiff_t>(r));
      finish(done.row, outcome_of(rows[done.row], done, status, files_of(rows[done.row].stability_case, options.output)));
    }
    std::this_thread::sleep_for(poll_every);
  }
}

std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (char c : text) {
    if (c == '"') out += '"';
    out += c == '\n' ? ' ' : c;
  }
  return out + "\"";
}

}  // namespace

std::vector<StabilityCase> select_cases(const std::vector<StabilityCase>& cases, const std::string& pattern) {
  std::vector<StabilityCase> selected;
  for (const StabilityCase& c : cases)
    if (c.name.find(pattern) != std::string::npos || c.axis.find(pattern) != std::string::npos) selected.push_back(c);
  if (selected.empty()) throw UsageError(fmt::format("--only '{}': no case has that in its name or axis; --list prints them", pattern));
  return selected;
}

long bad_count(const std::vector<StabilityRow>& rows) {
  return std::count_if(rows.begin(), rows.end(), [](const StabilityRow& r) { return is_bad(r.judgement.verdict); });
}

ExitCode exit_code_of(const std::vector<StabilityRow>& rows) { return bad_count(rows) == 0 ? ExitCode::done : ExitCode::not_trustworthy; }

std::string stability_csv(const std::vector<StabilityRow>& rows) {
  std::string csv =
      "case,axis,verdict,reason,simulated_s,steps,dt_mean_s,dt_min_s,limiter,rollbacks,energy_residual_relative,solid_volume_drift,J_min,distortion_controlled_fraction,"
      "self_intersections,closing_volume_ml,late_leak_ml_s,peak_velocity_m_s,papillary_force_N,seconds\n";
  for (const StabilityRow& row : rows) {
    const CaseOutcome& o = row.outcome;
    csv += fmt::format("{},{},{},{}", row.stability_case.name, quoted(row.stability_case.axis), name_of(row.judgement.verdict), quoted(row.judgement.reason));
    // A case without a step has no numbers.
    if (o.steps > 0)
      csv += fmt::format(",{:.6g},{},{:.4g},{:.4g},{},{},{:.4g},{:.4g},{:.4g},{:.4g},{},{},{:.4g},{:.4g},{:.4g}", o.simulated_s, o.steps, o.dt_mean_s, o.dt_min_s, o.limiter,
                         o.rollbacks, o.energy_residual, o.volume_drift, o.J_min, o.controlled_fraction, o.self_intersections,
                         o.has_closed ? fmt::format("{:.4g}", o.closing_volume_ml) : "", o.late_leak_ml_s, o.peak_velocity_m_s, o.papillary_force_N);
    else
      csv += std::string(15, ',');
    csv += fmt::format(",{:.2f}\n", o.seconds);
  }
  return csv;
}

std::vector<StabilityRow> run_stability(const std::vector<StabilityCase>& cases, const StabilityOptions& options) {
  const auto start = Clock::now();
  for (const char* folder : {"outcomes", "logs"}) make_directory(options.output / folder);
  // One thread a case; and no team of threads may exist in this process when it forks.
  set_thread_count(1);
  const auto geometries = make_geometries(cases, options);
  std::vector<StabilityRow> rows;
  for (const StabilityCase& c : cases) rows.push_back({c, {}, {}});
  if (!(options.is_interrupted && *options.is_interrupted)) {
    spdlog::info("{} geometries made in {:.0f} s", geometries.size(), seconds_since(start));
    run_children(rows, geometries, options);
  }
  if (options.is_interrupted && *options.is_interrupted) return {};
  write_text_atomically(options.output / "stability.csv", stability_csv(rows));
  write_text_atomically(options.output / "stability.html", stability_page(rows, seconds_since(start), options.jobs));
  return rows;
}

}  // namespace mv
