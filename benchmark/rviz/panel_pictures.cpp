// panel_pictures CONFIG.rviz SECONDS [PICTURE.png PART WORDS]...
// Opens rviz with a configuration and takes pictures of the screen, one after the other: each when
// the panel's PART (`state`, `advice`) comes to say WORDS; with the part `key_scans`, when there
// are so many; with `places`, when the list of places is there that a click on Relocalise asks for.
// Fails when one takes longer than SECONDS, or when a display has a warning or an error in the
// moment of a picture.

#include <ros/ros.h>
#include <rviz/display_group.h>
#include <rviz/properties/status_property.h>
#include <rviz/visualization_frame.h>
#include <rviz/visualization_manager.h>

#include <QApplication>
#include <QElapsedTimer>
#include <QLabel>
#include <QListWidget>
#include <QPixmap>
#include <QPushButton>
#include <QScreen>
#include <cstdlib>
#include <functional>
#include <iostream>
#include <string>
#include <vector>

namespace {

/// Handles what happens until it is so; false when that takes too long.
bool becomes_so(const std::function<bool()>& is_so, qint64 milliseconds) {
  QElapsedTimer timer;
  timer.start();
  while (!is_so() && timer.elapsed() < milliseconds) {
    QApplication::processEvents(QEventLoop::AllEvents, 20);
  }
  return is_so();
}

/// Warnings and errors of a display and all that is in it.
void find_trouble(const rviz::Property& property, const std::string& path,
                  std::vector<std::string>& trouble) {
  const std::string name = path + "/" + property.getName().toStdString();
  const auto* const status = dynamic_cast<const rviz::StatusProperty*>(&property);
  if (status != nullptr && status->getLevel() != rviz::StatusProperty::Ok) {
    trouble.push_back(name + ": " + status->getValue().toString().toStdString());
  }
  for (int k = 0; k < property.numChildren(); ++k) {
    find_trouble(*property.childAt(k), name, trouble);
  }
}

class Photographer {
 public:
  Photographer(rviz::VisualizationFrame& frame, qint64 patience)
      : frame_(frame), patience_(patience) {}

  /// Whether there is a picture, and nothing wrong in it.
  bool take(const std::string& file, const std::string& part, const std::string& words) {
    if (part == "places") {
      frame_.findChild<QPushButton*>("relocalise")->click();
    }
    if (!becomes_so([&] { return shows(part, words); }, patience_)) {
      std::cerr << file << ": " << part << " never says '" << words << "', but '" << text("state")
                << "'; " << text("answer") << "\n";
      return false;
    }
    becomes_so([] { return false; }, 1500);  // until all is drawn
    std::vector<std::string> trouble;
    find_trouble(*frame_.getManager()->getRootDisplayGroup(), "", trouble);
    for (const std::string& one : trouble) {
      std::cerr << file << ": " << one << "\n";
    }
    const bool is_saved = QApplication::screens().front()->grabWindow(0).save(file.c_str());
    std::cout << file << ": " << text("state") << "; " << text("advice") << std::endl;
    return is_saved && trouble.empty();
  }

 private:
  std::string text(const char* label) const {
    return frame_.findChild<QLabel*>(label)->text().toStdString();
  }

  [[nodiscard]] bool shows(const std::string& part, const std::string& words) const {
    if (part == "places") {
      return frame_.findChild<QListWidget*>("places")->count() > 0;
    }
    if (part == "key_scans") {
      const std::string figures = text("figures");
      const std::size_t line = figures.find('\n');
      return line != std::string::npos && std::atoi(figures.c_str() + line) >= std::stoi(words);
    }
    return text(part.c_str()).find(words) != std::string::npos;
  }

  rviz::VisualizationFrame& frame_;
  const qint64 patience_;  ///< [ms]
};

}  // namespace

int main(int argc, char** argv) {
  QApplication application(argc, argv);
  ros::init(argc, argv, "rviz", ros::init_options::NoSigintHandler);
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  if (arguments.size() < 2 || arguments.size() % 3 != 2) {
    std::cerr << "usage: panel_pictures CONFIG.rviz SECONDS [PICTURE.png PART WORDS]...\n";
    return 2;
  }
  rviz::VisualizationFrame frame;
  frame.setApp(&application);
  frame.setSplashPath("");
  frame.initialize(QString::fromStdString(arguments[0]));
  frame.show();
  frame.move(0, 0);
  if (frame.findChild<QLabel*>("state") == nullptr) {
    std::cerr << arguments[0] << " has no panel of the SLAM node, or it could not be loaded\n";
    return 1;
  }
  Photographer photographer(frame, 1000 * std::stoll(arguments[1]));
  bool is_well = true;
  for (std::size_t k = 2; k + 2 < arguments.size(); k += 3) {
    is_well = photographer.take(arguments[k], arguments[k + 1], arguments[k + 2]) && is_well;
  }
  return is_well ? 0 : 1;
}
