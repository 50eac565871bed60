/* The recursive filter on a flight computer: its interface in C.
 *
 * What it estimates, and from which equations, stands in information_filter.hpp, which Python calls
 * too: the same samples give the same bits (conservation_equations.hpp says what a sample is).
 *
 * No function allocates, throws, recurses, keeps anything, reads or writes a file, or waits. A
 * filter is a constant table of its robot, `robot.h` as `orbident export --flight` writes it, and
 * one array of numbers, the caller's: first all that is carried from sample to sample, then room
 * for one step. Two filters may run at once in two arrays.
 */
#ifndef ORBIDENT_FLIGHT_H
#define ORBIDENT_FLIGHT_H

#ifndef ORBIDENT_REAL
#define ORBIDENT_REAL double /* or float: everything is of this type */
#endif

#ifdef __cplusplus
#define ORBIDENT_CONSTANT constexpr
extern "C" {
#else
#define ORBIDENT_CONSTANT static const
#endif

typedef ORBIDENT_REAL orbident_real;

/* What a call says. Below zero it changed nothing, unless said otherwise. From zero on no number
 * that it gives is NaN. */
enum orbident_code {
  ORBIDENT_DONE = 0,
  ORBIDENT_NO_VELOCITY = 1, /* the sample counts for the momentum alone: it has no velocity of S */
  ORBIDENT_CHANGED = 2,     /* the robot changed: a capture, a release, a loss */
  ORBIDENT_NO_SCALE = 3,    /* the estimate is given, but nothing told its scale: no wheel turns.
                               All but quotients of its numbers is what was believed before */

  ORBIDENT_INCOMPLETE = -1, /* a number of the sample is NaN or infinite: it does not count */
  ORBIDENT_ABSURD = -2,    /* a number beyond reason, or a quaternion of zeros: it does not count */
  ORBIDENT_NOT_LATER = -3, /* the time is not after the last sample's: it does not count. Where the
                              clock was set back, or was far ahead, go on by orbident_open */
  ORBIDENT_REPEATED = -4,  /* the gyro's numbers are the last ones to the last digit: it is dead,
                              or the sample came twice; it does not count */
  ORBIDENT_NO_MEMORY = -5, /* the array is too small: orbident_memory says how large it must be */
  ORBIDENT_NO_STATE = -6,  /* the array holds no filter of this robot: orbident_init or _restore */
  ORBIDENT_DIVERGED = -7,  /* numbers ran out of range, and the estimate is lost; every call says so
                              until orbident_init or _restore */
  ORBIDENT_NO_SUCH = -8,   /* there is no such quantity, or `out` has another size */
  ORBIDENT_SPOILED = -9, /* the saved state is damaged, or not of orbident_save: take an older copy,
                            or begin anew */
  ORBIDENT_NO_SAMPLE = -10 /* no sample counted since the last call: there is nothing to detect */
};

/* What orbident_get gives. */
enum orbident_quantity {
  ORBIDENT_BETA = 0,       /* the base parameters [M, sigma, iota], kg, kg m, kg m^2 */
  ORBIDENT_DEVIATIONS = 1, /* their standard deviations */
  ORBIDENT_NUISANCES = 2,  /* [h_cm, v_cm, p, b_g, b_a, drives]: N m s, m/s, N m s, rad/s, m/s^2; p
                              of joints with torques, and of each [armature, viscous, Coulomb
                              friction, offset, scale] (kg m^2, N m s, N m, N m, 1) */
  ORBIDENT_INNOVATION = 3  /* the last sample's, whitened; zero if it did not count */
};

/* A joint as robot files have it. */
typedef struct orbident_joint {
  int parent;            /* body that carries it; joint k moves body k + 1 */
  int revolute;          /* or 0: prismatic */
  orbident_real axis[3]; /* unit vector, joint axes */
  orbident_real R_PJ[9]; /* joint axes at zero in the parent's, row by row */
  orbident_real p_PJ[3]; /* from the parent's origin, m */
} orbident_joint;

typedef struct orbident_wheel {
  orbident_real axis[3]; /* unit vector, base axes */
  orbident_real inertia; /* kg m^2 */
} orbident_wheel;

/* A joint whose torque is measured: conservation_equations.hpp. */
typedef struct orbident_driven {
  int joint;
  orbident_real walk;     /* what the torque's noise adds to the momentum, N m s/sqrt(s) */
  orbident_real still;    /* slower it may stand, rad/s or m/s */
  orbident_real known[5]; /* armature, viscous and Coulomb friction, offset, scale: beforehand, */
  orbident_real std[5];   /* and their deviations */
} orbident_driven;

/* By columns: column c has the entries first[c] .. first[c + 1] - 1. */
typedef struct orbident_sparse {
  const int* first;
  const int* row;
  const orbident_real* value;
  int columns;
} orbident_sparse;

/* The constant table of a robot and its filter. */
typedef struct orbident_robot {
  long mark; /* of this table, so that a state of another is refused; at most 2^24 */
  int joints, wheels;
  const orbident_joint* joint;
  const orbident_wheel* wheel;
  orbident_sparse theta_of_linear, theta_of_sigma; /* regressors.hpp */
  const int* product; /* of Y: which of sigma are multiplied, in pairs */
  int products;
  orbident_sparse theta_of_beta;
  int momentum[3], momenta;      /* base axes in which momentum is conserved, how many */
  int velocity[3], velocities;   /* and linear momentum */
  orbident_real noise[11];       /* SensorNoise of conservation_equations.hpp, in its order */
  int accelerometer;             /* whether the velocity is integrated from one */
  const orbident_driven* driven; /* joints with torques, */
  int driven_joints;             /* how many, */
  orbident_real longest;         /* and over how long they can be followed, s */
  orbident_sparse pi_of_shown, pi_of_products; /* parameters_of_beta.hpp */
  const int* pair;
  int pis, sigmas, iotas;
  const orbident_real* beta;    /* believed beforehand, */
  const orbident_real* root;    /* and how surely: root^T root is its information, row by row */
  const orbident_real* opening; /* what a change of the robot may do, L of a covariance L L^T */
  int window;                   /* samples that the onset of a change may lie back */
  orbident_real threshold;      /* of the statistic g of change_detection.hpp */
} orbident_robot;

typedef struct orbident_detection {
  orbident_real statistic; /* g over its threshold */
  orbident_real onset;     /* time of the first sample of the change, most likely */
} orbident_detection;

/* Numbers of the whole array, and of its first part: all that has to be kept to go on later. */
long orbident_memory(const orbident_robot* robot);
long orbident_state(const orbident_robot* robot);

/* Begins at a first sample, which sets the momentum's scale and is not used up: step with it too.
 *   memory   `numbers` of them; best at a multiple of 64 bytes
 *   sample   [q, qd, w, x_WB, qd_rw, v_S, w_smooth, h_given, impulses], see
 *            conservation_equations.hpp; an impulse is a torque's integral so far, N m s, or NaN
 *   h_cm     the momentum where it is known, inertial axes, N m s; else a null pointer
 * Returns ORBIDENT_DONE, _INCOMPLETE, _ABSURD or _DIVERGED, after which the array holds no filter,
 * or _NO_MEMORY. */
int orbident_init(const orbident_robot* robot, orbident_real* memory, long numbers,
                  const orbident_real* sample, const orbident_real* h_cm);

/* Writes orbident_state numbers to `saved`: a copy of the state, with a checksum.
 * Returns ORBIDENT_DONE, _NO_STATE or _DIVERGED. */
int orbident_save(const orbident_robot* robot, orbident_real* memory, orbident_real* saved);

/* Begins where another array was when orbident_save wrote `saved`. The checksum and every number
 * are looked at first: whether it is finite, a time not after the last one, a count in its range, a
 * factor regular.
 * Returns ORBIDENT_DONE, _NO_MEMORY, _NO_STATE, _SPOILED or _DIVERGED. */
int orbident_restore(const orbident_robot* robot, orbident_real* memory, long numbers,
                     const orbident_real* saved);

/* Takes one sample of time t (s) in. */
int orbident_step(const orbident_robot* robot, orbident_real* memory, orbident_real t,
                  const orbident_real* sample);

/* Whether the robot changed, by the last step; call it once after every step. It writes to `out` if
 * its code is not below zero.
 * Returns ORBIDENT_DONE, _CHANGED, _NO_SAMPLE, _NO_STATE or _DIVERGED. */
int orbident_detect(const orbident_robot* robot, orbident_real* memory, orbident_detection* out);

/* Goes on after a change: what is believed becomes as uncertain as the change may have made it, and
 * nothing is known of the momentum. Also where the clock was set: samples are taken from t on.
 * Returns ORBIDENT_DONE, _INCOMPLETE, _NO_STATE or _DIVERGED. */
int orbident_open(const orbident_robot* robot, orbident_real* memory, orbident_real t);

/* A quantity, as many numbers as it has.
 * Returns ORBIDENT_DONE, _NO_SCALE, _NO_SUCH, _NO_STATE or _DIVERGED. */
int orbident_get(const orbident_robot* robot, orbident_real* memory, int quantity,
                 orbident_real* out, int size);

#ifdef __cplusplus
}
#endif
#endif
