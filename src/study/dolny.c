/// The studies of the thesis "Staggered variational elasticity" (Dolny 2025).
#include "study/dolny_studies.h"

const LthStudy lth_studies_dolny[] = {
    {"dolny/table5.1", "Traction outside, held inside (Fig. 5.2)",
     "Is the error with a traction boundary smaller than the printed one at every N, and of second "
     "order?",
     lth_study_table_5_1},
    {"dolny/table5.2", "Held on both sides (Fig. 5.3)",
     "Are the printed errors met, and what are they the errors of?", lth_study_table_5_2},
    {"dolny/fig5.1", "Where the error lies", "Where is the error of the two tables?",
     lth_study_error_maps},
    {"dolny/free", "What the tables hide: free boundaries",
     "What are the orders where a boundary is really free, and what do smooth fractions make of "
     "them?",
     lth_study_free_boundaries},
    {"dolny/fig5.4", "Condition numbers", "How does the matrix depend on nu and E?",
     lth_study_condition},
    {"dolny/fig5.5", "Expansion", "Do the free sides of a stretched rectangle come in?",
     lth_study_expansion},
    {"dolny/fig5.6", "Compression", "Do the free sides of a pressed rectangle bulge?",
     lth_study_compression},
    {"dolny/fig5.7", "Shear", "Does a sheared rectangle stay symmetric about its centre?",
     lth_study_shear},
    {"dolny/fig5.8", "Gravity",
     "Does a rectangle held at its ends sag in proportion to its weight?", lth_study_gravity},
    {"dolny/fig5.9", "A circle pulled at its corners",
     "Does a curved boundary keep the symmetry of what pulls it?", lth_study_circle},
    {"dolny/fig5.10", "A bunny pulled by ears and feet",
     "Does a shape without a formula deform as simply?", lth_study_silhouette},
    {"dolny/fig5.11", "A square that turns",
     "How much does a turn inflate the linear model, and is the corotated one free of that?",
     lth_study_rotation},
    {0}};
