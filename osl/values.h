/* What the tables of a fit hold: values of all its channels. Equal channels share a column of the tables; where all
 * channels are equal, values are floats. */
#if STORED == 1
#  define VALUE float
#  define READ(table, i) table[i]
#else
#  define VALUE color
#  define READ(table, i) color(table[STORED * (i) + CHANNEL_0], table[STORED * (i) + CHANNEL_1], \
                               table[STORED * (i) + CHANNEL_2])
#endif
