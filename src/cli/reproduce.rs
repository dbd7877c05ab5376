//! `seamtrack reproduce`: the papers' tables beside ours.

use std::process::ExitCode;

use anyhow::Context;
use clap::{Args, ValueEnum};
use seamtrack::reproduce::{Table, du, infrared, jiang, zhang};

/// Run a paper's experiment as printed and put its figures beside ours
#[derive(Debug, Args)]
pub struct Reproduce {
    /// Which paper
    paper: Paper,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Paper {
    /// Zhang 2009: polyline with outliers, closed loop on a skew weld
    Zhang,
    /// Du 2022: butt and lap weld
    Du,
    /// Infrared paper: worked step, ratio of error variances
    Infrared,
    /// Jiang 2016: width of a clad
    Jiang,
    /// All of them
    All,
}

impl Reproduce {
    /// Prints the tables as each paper's are done.
    pub fn run(&self) -> anyhow::Result<ExitCode> {
        let all = [Paper::Zhang, Paper::Du, Paper::Infrared, Paper::Jiang];
        for paper in all.into_iter().filter(|paper| self.paper == Paper::All || self.paper == *paper) {
            for table in tables(paper)? {
                super::say::print(&format!("{table}\n"))?;
            }
        }
        Ok(ExitCode::SUCCESS)
    }
}

fn tables(paper: Paper) -> anyhow::Result<Vec<Table>> {
    let tables = match paper {
        Paper::Zhang => zhang::tables(),
        Paper::Du => {
            let rendered = du::rendered::tables().context("the rendered scenes cannot be tracked")?;
            du::simulated_tables().map(|simulated| simulated.into_iter().chain(rendered).collect())
        }
        Paper::Infrared => {
            let rendered = infrared::rendered_table().context("the rendered scene cannot be measured")?;
            infrared::tables().map(|simulated| simulated.into_iter().chain([rendered]).collect())
        }
        Paper::Jiang => {
            let rendered = jiang::rendered_table().context("the rendered scene cannot be measured")?;
            jiang::tables().map(|simulated| simulated.into_iter().chain([rendered]).collect())
        }
        Paper::All => Ok(vec![]),
    };
    tables.context("the experiment's filter broke down")
}
