/// Figures 5.5 to 5.11: bodies pulled, pressed, sheared, hung up and turned.
#include "study/dolny_studies.h"

#include "study/dolny_scenes.h"
#include "study/frames.h"

static const char shape_caption[] =
    "Colour is von Mises stress (dark: none), dots are held boundary points";

/// Run one of the scenes of studies/dolny and draw its states.
static LitheStatus run_shape(LthStudyRun *run, const char *name, const char *scene, const char *set,
                             LthFrames *frames, LthStudyResult *result) {
  *frames = (LthFrames){.run = run};
  LthRunLook look = {lth_frames_look, frames};
  LITHE_TRY(lth_study_run_with(run, name, scene, set ? 1 : 0, &set, &look, result));
  return lth_frames_draw(frames, lth_study_print(run, "states-%s", name),
                         lth_study_print(run, "%s: %s", name, shape_caption));
}

static double probe(LthStudyRun *run, const LthStudyResult *r, const char *name, int axis) {
  return lth_study_number(r, lth_study_print(run, "probes.%s.displacement.%d", name, axis));
}

/// What constraints exert together over what the largest does, where nothing else acts.
static void judge_balance(LthStudyRun *run, const LthStudyResult *result, int n_constraints) {
  double sum[2] = {0}, largest = 0;
  for (int i = 0; i < n_constraints; i++)
    for (int a = 0; a < 2; a++) {
      double f = lth_study_number(
          result, lth_study_print(run, "reaction.bodies.0.constraints.%d.%d", i, a));
      sum[a] += f;
      largest = fabs(f) <= largest ? largest : fabs(f);
    }
  lth_study_at_most(&run->report, "sum of all reactions over the largest",
                    fmax(fabs(sum[0]), fabs(sum[1])) / largest, 1e-7,
                    "no other force acts; the solve leaves 1e-10 of the forces");
}

/// How far the free sides of a stretched rectangle move in, as a share of what a bar of the same material would.
static LitheStatus run_stretch(LthStudyRun *run, const char *name, const char *scene, double sign) {
  LthFrames frames;
  LthStudyResult result;
  LITHE_TRY(run_shape(run, name, scene, NULL, &frames, &result));
  double left = probe(run, &result, "left", 0), right = probe(run, &result, "right", 0);
  double bar = 0.3 / 0.7 * 0.3 * 0.39; // nu / (1 - nu) times strain times distance from the middle
  LthStudyReport *r = &run->report;
  lth_study_at_least(
      r, "motion of the free sides towards (away from) each other over a bar's",
      sign * (left - right) / 2 / bar, 0.5,
      "plane strain: a bar moves in by nu / (1 - nu) of its strain; held ends hinder it");
  lth_study_at_most(r, "the same from above", sign * (left - right) / 2 / bar, 1.05,
                    "the middle of a short rectangle contracts little more than a bar");
  lth_study_at_most(r, "asymmetry of the free sides", fabs(left + right) / fabs(left - right), 1e-7,
                    "the scene is symmetric; the solve leaves 1e-10 of the forces");
  judge_balance(run, &result, 2);
  return LITHE_OK;
}

LitheStatus lth_study_expansion(LthStudyRun *run) {
  return run_stretch(run, "expansion", lth_scene_expansion, 1);
}

LitheStatus lth_study_compression(LthStudyRun *run) {
  return run_stretch(run, "compression", lth_scene_compression, -1);
}

LitheStatus lth_study_shear(LthStudyRun *run) {
  LthFrames frames;
  LthStudyResult result;
  LITHE_TRY(run_shape(run, "shear", lth_scene_shear, NULL, &frames, &result));
  double worst = 0, size = 0;
  for (int a = 0; a < 2; a++) {
    double up = probe(run, &result, "upper", a), low = probe(run, &result, "lower", a);
    worst = fabs(up + low) <= worst ? worst : fabs(up + low);
    size = fmax(size, fabs(up));
  }
  lth_study_at_most(&run->report, "asymmetry about the centre", worst / size, 1e-7,
                    "a half turn maps the scene onto itself; the solve leaves 1e-10 of the forces");
  judge_balance(run, &result, 2);
  return LITHE_OK;
}

/// Sag of the middle in every state; what a frame does not have a probe of, its lowest place has.
static double lowest_middle(const LthFrame *f) {
  double low = INFINITY;
  for (int c = 0; c < f->n; c++)
    for (int i = 0; i < f->corners[c]; i++) {
      const double *x =
          f->place + (size_t)2 * LTH_FRAME_CORNERS * (size_t)c + (size_t)2 * (size_t)i;
      if (fabs(x[0]) < 1e-6) low = fmin(low, x[1]);
    }
  return low;
}

LitheStatus lth_study_gravity(LthStudyRun *run) {
  static const double weight[4] = {0, 0.42, 0.73, 1.11};
  LthFrames frames;
  LthStudyResult result;
  LITHE_TRY(run_shape(run, "gravity", lth_scene_gravity, NULL, &frames, &result));
  LthTable *t = lth_study_table(&run->report, "sag", "Sag of the lower edge's middle", NULL);
  lth_table_column(t, "weight as printed", "", 3);
  lth_table_column(t, "sag", "m", 6);
  lth_table_column(t, "sag over weight", "m", 6);
  double worst = 0, first = NAN;
  for (int k = 0; k < frames.n && k < 4; k++) {
    double sag = -0.4 - lowest_middle(&frames.frame[k]), share = sag / weight[k];
    lth_table_row(t, NULL, (double[]){weight[k], sag, weight[k] > 0 ? share : NAN});
    if (k == 1) first = share;
    if (k > 1) worst = fabs(share / first - 1) <= worst ? worst : fabs(share / first - 1);
  }
  lth_study_at_most(&run->report, "sag per weight, largest relative difference",
                    frames.n == 4 ? worst : NAN, 1e-6,
                    "the model is linear; the solve leaves 1e-10 of the forces");
  double force = 0;
  for (int i = 0; i < 2; i++)
    force +=
        lth_study_number(&result, lth_study_print(run, "reaction.bodies.0.constraints.%d.1", i));
  lth_study_at_most(&run->report, "reactions against the weight, relative",
                    fabs(force / 0.0111 - 1), 1e-7, "what is held carries the whole weight");
  return LITHE_OK;
}

LitheStatus lth_study_circle(LthStudyRun *run) {
  static const char *const names[4] = {"right", "top", "left", "bottom"};
  LthFrames frames;
  LthStudyResult result;
  LITHE_TRY(run_shape(run, "circle", lth_scene_circle, NULL, &frames, &result));
  double worst = 0, out = probe(run, &result, "right", 0);
  for (int k = 0; k < 4; k++) {
    double along = (k < 2 ? 1 : -1) * probe(run, &result, names[k], k % 2);
    double across = fabs(probe(run, &result, names[k], 1 - k % 2));
    double off = fmax(fabs(along - out), across);
    worst = off <= worst ? worst : off;
  }
  lth_study_at_most(
      &run->report, "difference of the four free pieces over what is pulled", worst / 0.2, 1e-7,
      "a quarter turn maps the scene onto itself; the solve leaves 1e-10 of the forces");
  judge_balance(run, &result, 4);
  return LITHE_OK;
}

LitheStatus lth_study_silhouette(LthStudyRun *run) {
  LthFrames frames;
  LthStudyResult result;
  LITHE_TRY(run_shape(run, "bunny", lth_scene_bunny, NULL, &frames, &result));
  judge_balance(run, &result, 2);
  double up = lth_study_number(&result, "reaction.bodies.0.constraints.1.1");
  lth_study_at_least(&run->report, "pull at the ears over Young's modulus times 1 m", up / 0.1,
                     0.005, "stretched by 0.3 of its height, it pulls back");
  return LITHE_OK;
}

// --- Figure 5.11 ---

static void tell_areas(LthTable *t, const char *word, const LthFrames *frames, double *worst) {
  double row[4];
  *worst = 0;
  for (int k = 0; k < 4; k++) {
    row[k] = k < frames->n ? frames->frame[k].area / 0.64 - 1 : NAN;
    *worst = fabs(row[k]) <= *worst ? *worst : fabs(row[k]);
  }
  lth_table_row(t, word, row);
}

LitheStatus lth_study_rotation(LthStudyRun *run) {
  LthFrames linear, turned;
  LthStudyResult result, free_of_it;
  double growth, rest;
  LITHE_TRY(run_shape(run, "linear", lth_scene_rotation, NULL, &linear, &result));
  LITHE_TRY(run_shape(run, "corotated", lth_scene_rotation, "bodies.0.material.model=corotated",
                      &turned, &free_of_it));
  LthTable *t = lth_study_table(&run->report, "area", "Growth of the area, relative", "model");
  for (int k = 0; k < 4; k++)
    lth_table_column(t, lth_study_print(run, "%d degrees", 15 * k), "", 3);
  tell_areas(t, "linear", &linear, &growth);
  tell_areas(t, "corotated", &turned, &rest);
  LthStudyReport *r = &run->report;
  lth_study_at_least(
      r, "growth of the area under the linear model", growth, 0.02,
      "the artefact of the thesis' Fig. 5.11: a turn of 45 degrees looks to the linear "
      "strain like a compression by 1 - cos 45 = 29 %, which free sides evade");
  lth_study_at_most(r, "growth of the area under the corotated model", rest, 1e-6,
                    "a turn strains nothing; Newton's method stops at 1e-8 or so of the forces");
  lth_study_at_most(r, "distance of the corotated square from the turned one over its side",
                    lth_study_number(&free_of_it, "error.linf") / 0.8, 1e-6,
                    "the turned square is the exact solution");
  return LITHE_OK;
}
