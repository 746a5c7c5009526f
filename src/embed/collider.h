/// Where a rigid collider is at a time, and distances in its own frame.
#pragma once

#include "embed/contact.h"

/// world = R (rest - pivot) + pivot + shift
typedef struct LthPose {
  double R[9], pivot[3], shift[3];
} LthPose;

LthPose lth_collider_pose(const LthCollider *collider, double t);
void lth_pose_to_rest(const LthPose *pose, const double x[3], double rest[3]);
void lth_pose_to_world(const LthPose *pose, const double rest[3], double x[3]);

/// Gap and normal in the collider's rest frame; `normal` may be NULL.
double lth_collider_rest_gap(const LthCollider *collider, const double rest[3], double normal[3]);

/// Box of the collider in its rest frame; infinite for a plane.
void lth_collider_rest_box(const LthCollider *collider, double box[6]);
