# What R says about the published data sets beside it: writes r_output.csv.
# Run once, in this folder: Rscript reference.R
# Debian: r-base-core r-cran-{afex,car,coin,effectsize,exactranktests}
suppressPackageStartupMessages({
  library(afex)
  library(car)
  library(coin)
  library(exactRankTests)
})
options(contrasts = c("contr.sum", "contr.poly"))

found <- list()
add <- function(dataset, convention, values) {
  found[[length(found) + 1]] <<- data.frame(
    dataset = dataset, convention = convention, quantity = names(values),
    value = sprintf("%.17g", unname(values))
  )
}

# --- Student's sleep: ten pairs ------------------------------------------------------------------
sleep <- read.csv("sleep.csv")
d <- sleep$extra[sleep$group == 1] - sleep$extra[sleep$group == 2]
test <- t.test(d)
add("sleep", "paired t, two-sided", c(
  t = unname(test$statistic), df = unname(test$parameter), p = test$p.value,
  low = test$conf.int[1], high = test$conf.int[2], cohen_dz = mean(d) / sd(d)
))
steps <- round(10 * d)
add("sleep", "Wilcoxon, zeros dropped, exact", c(p = wilcox.exact(steps)$p.value))
for (zeros in c("Pratt", "Wilcoxon")) {
  test <- wilcoxsign_test(steps ~ rep(0, 10), zero.method = zeros, distribution = exact())
  add("sleep", paste(zeros, "zeros"), c(
    z = as.numeric(statistic(test, type = "standardized")), p_exact = as.numeric(pvalue(test))
  ))
}

# --- Tooth growth: two between factors ------------------------------------------------------------
teeth <- read.csv("ToothGrowth.csv")
teeth$dose <- factor(teeth$dose)
for (type in c("II", "III")) {
  table <- Anova(lm(len ~ supp * dose, teeth), type = type)
  for (effect in c("supp", "dose", "supp:dose")) {
    add("ToothGrowth", sprintf("between, type %s, %s", type, gsub(":", " × ", effect)), c(
      f = table[effect, "F value"], p = table[effect, "Pr(>F)"]
    ))
  }
}

# --- O'Brien & Kaiser (1985): mixed and within designs ---------------------------------------------
obk <- read.csv("obk_long.csv")
obk$id <- factor(obk$id)
ours <- function(effect) gsub(":", " × ", effect)
one <- function(fit, type, design) {
  table <- fit$Anova
  out <- suppressWarnings(summary(table, multivariate = FALSE))
  univariate <- unclass(out$univariate.tests)
  univariate <- univariate[rownames(univariate) != "(Intercept)", , drop = FALSE]
  sphere <- unclass(out$sphericity.tests)
  corrected <- unclass(out$pval.adjustments)
  ges <- anova(fit, es = "ges", correction = "none")
  for (effect in rownames(univariate)) {
    label <- sprintf("%s, type %s, %s", design, type, ours(effect))
    add("obk.long", label, c(
      f = univariate[effect, "F value"], p = univariate[effect, "Pr(>F)"], ges = ges[effect, "ges"]
    ))
    if (effect %in% rownames(sphere)) {
      add("obk.long", label, c(
        # not its p: car puts the number of cells where that of contrasts belongs
        mauchly_w = sphere[effect, 1],
        greenhouse_geisser = corrected[effect, "GG eps"], p_gg = corrected[effect, "Pr(>F[GG])"],
        huynh_feldt = corrected[effect, "HF eps"], p_hf = corrected[effect, "Pr(>F[HF])"]
      ))
    }
  }
}
for (type in c("II", "III")) {
  number <- c(II = 2, III = 3)[[type]]
  one(suppressMessages(suppressWarnings(aov_ez("id", "value", obk,
    between = "treatment", within = "phase", type = number, fun_aggregate = mean
  ))), type, "treatment (between) and phase")
  one(suppressMessages(suppressWarnings(aov_ez("id", "value", obk,
    between = c("treatment", "gender"), within = "phase", type = number, fun_aggregate = mean
  ))), type, "treatment and gender (between) and phase")
}
one(suppressMessages(suppressWarnings(aov_ez("id", "value", obk,
  within = c("phase", "hour"), type = 3, fun_aggregate = mean
))), "III", "phase and hour")

write.csv(do.call(rbind, found), "r_output.csv", row.names = FALSE, quote = c(2), na = "")
