#pragma once

#include <rviz/panel.h>

#include <QTimer>
#include <memory>
#include <string>

#include "rviz/slam_client.hpp"

class QComboBox;
class QLabel;
class QLineEdit;
class QListWidget;
class QPushButton;

namespace matchbox_slam {

/// A panel of rviz that shows how a SLAM node is, and asks things of it. Which node is saved with
/// rviz's configuration, as `Node`. What is in it bears names that tests find it by: node, state,
/// advice, figures, matcher, file, save, load, pause, reset, relocalise, places, answer.
class SlamPanel : public rviz::Panel {
 public:
  explicit SlamPanel(QWidget* parent = nullptr);
  ~SlamPanel() override;

  void load(const rviz::Config& config) override;
  void save(rviz::Config config) const override;

 private:
  void lay_out();
  void connect_all();
  void follow(const QString& node);
  void ask_for_reset();
  void forget_reset();
  void refresh();
  void show_state(const SlamView& view);
  void show_choices(const SlamView& view);
  void show_places(const SlamView& view);
  void show_answer(const SlamView& view);

  std::unique_ptr<SlamClient> client_;  ///< none while the node's name is none
  std::string trouble_with_name_;
  SlamView shown_;
  QTimer refresh_timer_;
  QTimer reset_timer_;  ///< runs while another click on `reset_` resets
  // Qt deletes these with the panel.
  QLineEdit* node_;
  QLabel* state_;
  QLabel* advice_;
  QLabel* figures_;
  QLabel* hypotheses_;
  QComboBox* matcher_;
  QLineEdit* file_;
  QPushButton* save_;
  QPushButton* load_;
  QPushButton* pause_;
  QPushButton* reset_;
  QPushButton* relocalise_;
  QListWidget* places_;
  QLabel* answer_;
};

}  // namespace matchbox_slam
