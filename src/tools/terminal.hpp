#pragma once

#include <chrono>
#include <csignal>
#include <string>

#include "run/run_dialog.hpp"

namespace matchbox_slam {

/// What a command-line program says to a person: news on stdout, warnings and a progress bar on
/// stderr. Where that is no terminal, as in a log, a line of the progress now and then stands for
/// the bar.
class Terminal {
 public:
  /// @param quiet    no news and no progress.
  /// @param between  two lines of progress.
  explicit Terminal(bool quiet, std::chrono::milliseconds between = std::chrono::seconds(30));

  void inform(const std::string& line);
  void warn(const std::string& line);

  /// @param fraction  done, 0...1.
  void show_progress(double fraction, const std::string& text);

 private:
  void show_bar(double fraction, const std::string& text);
  void clear_bar();

  bool quiet_;
  bool has_bar_;
  int shown_percent_ = -1;
  std::chrono::milliseconds between_;
  std::chrono::steady_clock::time_point told_ = std::chrono::steady_clock::now();
};

/// Holds back SIGINT and SIGTERM, so that a program can end its work in good order. Make it before
/// any thread; a signal that came is left unanswered.
class InterruptGuard {
 public:
  InterruptGuard();

  [[nodiscard]] bool is_interrupted() const;

 private:
  sigset_t signals_{};
};

/// A dialog on a terminal. Both outlive it.
[[nodiscard]] RunDialog dialog_on(Terminal& terminal, const InterruptGuard& interrupt);

}  // namespace matchbox_slam
