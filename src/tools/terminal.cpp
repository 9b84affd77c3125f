#include "tools/terminal.hpp"

#include <unistd.h>

#include <cstddef>
#include <iomanip>
#include <iostream>

namespace matchbox_slam {

Terminal::Terminal(bool quiet, std::chrono::milliseconds between)
    : quiet_(quiet), has_bar_(!quiet && isatty(STDERR_FILENO) == 1), between_(between) {}

void Terminal::inform(const std::string& line) {
  if (!quiet_) {
    clear_bar();
    std::cout << line << std::endl;
  }
}

void Terminal::warn(const std::string& line) {
  clear_bar();
  std::cerr << "warning: " << line << std::endl;
}

void Terminal::show_progress(double fraction, const std::string& text) {
  if (has_bar_) {
    show_bar(fraction, text);
    return;
  }
  const auto now = std::chrono::steady_clock::now();
  if (!quiet_ && now - told_ >= between_) {
    told_ = now;
    std::cerr << static_cast<int>(100.0 * fraction) << " %: " << text << std::endl;
  }
}

void Terminal::show_bar(double fraction, const std::string& text) {
  const int percent = static_cast<int>(100.0 * fraction);
  if (percent == shown_percent_) {
    return;
  }
  shown_percent_ = percent;
  constexpr std::size_t kWidth = 40;
  const auto filled = static_cast<std::size_t>(fraction * static_cast<double>(kWidth));
  std::cerr << "\r[" << std::string(filled, '#') << std::string(kWidth - filled, ' ') << "] "
            << std::setw(3) << percent << " %  " << text << "  " << std::flush;
}

void Terminal::clear_bar() {
  if (has_bar_ && shown_percent_ >= 0) {
    std::cerr << "\r\033[K" << std::flush;
    shown_percent_ = -1;
  }
}

InterruptGuard::InterruptGuard() {
  sigemptyset(&signals_);
  sigaddset(&signals_, SIGINT);
  sigaddset(&signals_, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &signals_, nullptr);
}

bool InterruptGuard::is_interrupted() const {
  sigset_t pending{};
  sigpending(&pending);
  return sigismember(&pending, SIGINT) == 1 || sigismember(&pending, SIGTERM) == 1;
}

RunDialog dialog_on(Terminal& terminal, const InterruptGuard& interrupt) {
  return {[&terminal](const std::string& line) { terminal.inform(line); },
          [&terminal](const std::string& line) { terminal.warn(line); },
          [&terminal](double fraction, const std::string& text) {
            terminal.show_progress(fraction, text);
          },
          [&interrupt] { return interrupt.is_interrupted(); }};
}

}  // namespace matchbox_slam
