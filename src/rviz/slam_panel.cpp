#include "rviz/slam_panel.hpp"

#include <ros/exceptions.h>

#include <QComboBox>
#include <QFormLayout>
#include <QHBoxLayout>
#include <QLabel>
#include <QLineEdit>
#include <QListWidget>
#include <QPushButton>
#include <QVBoxLayout>
#include <chrono>
#include <initializer_list>
#include <utility>
#include <vector>

namespace matchbox_slam {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kRefresh{100};
constexpr milliseconds kTimeToConfirm{4000};

template <typename Widget>
Widget* named(const char* name, Widget* widget) {
  widget->setObjectName(name);
  return widget;
}

/// A label whose text takes as many lines as it needs. What a node says is not to be read as HTML.
QLabel* make_text(const char* name) {
  auto* label = named(name, new QLabel);
  label->setTextFormat(Qt::PlainText);
  label->setWordWrap(true);
  label->setTextInteractionFlags(Qt::TextSelectableByMouse);
  return label;
}

/// Keeps room for so many lines, so that nothing below moves when the text is another.
void reserve(int lines, QLabel* label) {
  label->setAlignment(Qt::AlignTop | Qt::AlignLeft);
  label->setMinimumHeight(lines * label->fontMetrics().lineSpacing());
}

template <typename... Widgets>
QHBoxLayout* in_a_row(Widgets*... widgets) {
  auto* row = new QHBoxLayout;
  (row->addWidget(widgets), ...);
  return row;
}

}  // namespace

SlamPanel::SlamPanel(QWidget* parent)
    : rviz::Panel(parent),
      node_(named("node", new QLineEdit("/slam"))),
      state_(make_text("state")),
      advice_(make_text("advice")),
      figures_(make_text("figures")),
      hypotheses_(make_text("hypotheses")),
      matcher_(named("matcher", new QComboBox)),
      file_(named("file", new QLineEdit)),
      save_(named("save", new QPushButton("Save"))),
      load_(named("load", new QPushButton("Load"))),
      pause_(named("pause", new QPushButton)),
      reset_(named("reset", new QPushButton)),
      relocalise_(named("relocalise", new QPushButton("Relocalise"))),
      places_(named("places", new QListWidget)),
      answer_(make_text("answer")) {
  lay_out();
  forget_reset();
  connect_all();
  follow(node_->text());
  refresh_timer_.start(kRefresh);
}

SlamPanel::~SlamPanel() = default;

void SlamPanel::lay_out() {
  node_->setToolTip("Name of the SLAM node, saved with rviz's configuration");
  file_->setToolTip(
      "On the node's computer: where Save writes .pgm, .yaml, .png and .slam; which .slam or .yaml "
      "file Load goes on with");
  reset_->setToolTip("Forgets map and trajectory");
  relocalise_->setToolTip("Looks where the newest scan may have been taken");
  places_->setToolTip("Click where the robot is");
  hypotheses_->setToolTip(
      "Where the robot may be, and the share of what is known that speaks for it");
  state_->setAlignment(Qt::AlignCenter);
  places_->setMinimumHeight(6 * places_->fontMetrics().lineSpacing());
  reserve(4, advice_);
  reserve(2, figures_);
  reserve(kMostHypothesisLines, hypotheses_);
  reserve(3, answer_);
  auto* form = new QFormLayout;
  form->addRow("Node", node_);
  auto* choices = new QFormLayout;
  choices->addRow("Matcher", matcher_);
  choices->addRow("Map file", file_);
  auto* all = new QVBoxLayout(this);
  all->addLayout(form);
  for (QLabel* label : {state_, advice_, figures_, hypotheses_}) {
    all->addWidget(label);
  }
  all->addLayout(choices);
  all->addLayout(in_a_row(save_, load_, pause_, reset_));
  all->addWidget(relocalise_);
  all->addWidget(places_, 1);
  all->addWidget(answer_);
}

void SlamPanel::connect_all() {
  const auto on_click = [this](QPushButton* button, auto work) {
    connect(button, &QPushButton::clicked, this, [this, work] {
      if (client_) {
        work();
      }
    });
  };
  on_click(save_, [this] { client_->save_map(file_->text().trimmed().toStdString()); });
  on_click(load_, [this] { client_->load_map(file_->text().trimmed().toStdString()); });
  on_click(pause_, [this] { client_->set_paused(!is_paused(shown_.report)); });
  on_click(reset_, [this] { ask_for_reset(); });
  on_click(relocalise_, [this] { client_->relocalise(); });
  connect(places_, &QListWidget::itemClicked, this, [this](QListWidgetItem* item) {
    if (client_) {
      client_->choose_place(static_cast<std::size_t>(places_->row(item)));
    }
  });
  connect(matcher_, QOverload<int>::of(&QComboBox::activated), this, [this](int index) {
    if (client_) {
      client_->choose_matcher(matcher_->itemText(index).toStdString());
    }
  });
  connect(node_, &QLineEdit::editingFinished, this, [this] {
    if (node_->isModified()) {
      follow(node_->text());
      Q_EMIT configChanged();
    }
  });
  connect(&refresh_timer_, &QTimer::timeout, this, [this] { refresh(); });
  reset_timer_.setSingleShot(true);
  connect(&reset_timer_, &QTimer::timeout, this, [this] { forget_reset(); });
}

void SlamPanel::load(const rviz::Config& config) {
  rviz::Panel::load(config);
  QString node;
  if (config.mapGetString("Node", &node)) {
    follow(node);
  }
}

void SlamPanel::save(rviz::Config config) const {
  rviz::Panel::save(config);
  config.mapSetValue("Node", node_->text());
}

/// Listens to this node, and to no other any more.
void SlamPanel::follow(const QString& node) {
  node_->setText(node);  // and so it is not modified
  forget_reset();        // of another node's map
  client_.reset();
  trouble_with_name_.clear();
  try {
    client_ = std::make_unique<SlamClient>(node.trimmed().toStdString());
  } catch (const ros::Exception& error) {
    trouble_with_name_ = error.what();
  }
  refresh();
}

/// A map is easily forgotten, and hard to make again: that takes two clicks.
void SlamPanel::ask_for_reset() {
  if (reset_timer_.isActive()) {
    forget_reset();
    client_->reset();
  } else {
    reset_timer_.start(kTimeToConfirm);
    reset_->setText("Forget the map?");
    reset_->setStyleSheet("color: #c62828; font-weight: bold");
  }
}

void SlamPanel::forget_reset() {
  reset_timer_.stop();
  reset_->setText("Reset");
  reset_->setStyleSheet("");
}

void SlamPanel::refresh() {
  SlamView view;
  if (client_) {
    view = client_->view();
  } else {
    view.node = "a node of that name";
    view.answer = trouble_with_name_;
    view.succeeded = false;
  }
  show_state(view);
  show_choices(view);
  show_places(view);
  show_answer(view);
  shown_ = std::move(view);
}

void SlamPanel::show_state(const SlamView& view) {
  const Assessment assessment = assess(view.report, view.node);
  state_->setText(QString::fromStdString(assessment.headline));
  const QString style = QString::fromStdString(
      "color: white; font-size: 18pt; font-weight: bold; padding: 4px; background: " +
      assessment.color);
  if (state_->styleSheet() != style) {
    state_->setStyleSheet(style);
  }
  advice_->setText(QString::fromStdString(assessment.advice));
  figures_->setText(QString::fromStdString(figures_of(view.report)));
  hypotheses_->setText(QString::fromStdString(hypotheses_of(view.report)));
  pause_->setText(is_paused(view.report) ? "Resume" : "Pause");
}

void SlamPanel::show_choices(const SlamView& view) {
  if (view.matchers != shown_.matchers) {
    matcher_->clear();
    for (const std::string& matcher : view.matchers) {
      matcher_->addItem(QString::fromStdString(matcher));
    }
  }
  // After an answer, too: what was chosen may have been refused.
  if (view.matchers != shown_.matchers || view.matcher != shown_.matcher ||
      view.answers != shown_.answers) {
    matcher_->setCurrentText(QString::fromStdString(view.matcher));
  }
  file_->setPlaceholderText(QString::fromStdString(view.map_file));
}

void SlamPanel::show_places(const SlamView& view) {
  std::vector<std::string> lines;
  for (const Place& place : view.places) {
    lines.push_back(text_of(place, lines.size() + 1));
  }
  bool is_shown = places_->count() == static_cast<int>(lines.size());
  for (int row = 0; is_shown && row < places_->count(); ++row) {
    is_shown = places_->item(row)->text().toStdString() == lines[static_cast<std::size_t>(row)];
  }
  if (!is_shown) {
    places_->clear();
    for (const std::string& line : lines) {
      places_->addItem(QString::fromStdString(line));
    }
  }
}

void SlamPanel::show_answer(const SlamView& view) {
  const bool is_idle = view.doing.empty();
  for (QWidget* widget : std::initializer_list<QWidget*>{save_, load_, pause_, reset_, relocalise_,
                                                         matcher_, places_}) {
    widget->setEnabled(is_idle);
  }
  answer_->setText(QString::fromStdString(is_idle ? view.answer : view.doing + " ..."));
  answer_->setToolTip(answer_->text());  // all of it, where it has more lines
  const QString style = is_idle && !view.succeeded ? "color: #c62828" : "";
  if (answer_->styleSheet() != style) {
    answer_->setStyleSheet(style);
  }
}

}  // namespace matchbox_slam
